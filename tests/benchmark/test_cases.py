"""The case sets: what they say they are, and the same for the same seed."""

from collections import Counter

import numpy as np
import pytest

from primfit.benchmark.cases import (
    ARCS,
    CASE_SETS,
    COORDINATES,
    EXACT,
    OBJECTS,
    OUTLIERS,
    PAIR_GROUPS,
    ROUND,
    SIZES,
    TEST_SET,
    turn,
)
from primfit.benchmark.nearest import off_every_kind
from primfit.benchmark.pieces import (
    BIAS_NOISE,
    BOW,
    CLEAR,
    GAINS,
    INDISTINGUISHABLE,
    LARGEST_RADIUS,
    NOISE_LAWS,
    PAIR_NOISE,
    PAIRS,
    PAIRS_OF,
    draw_pair,
    feet,
    largest_radius,
    noisy,
)
from primfit.fitting.names import KINDS
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.synthetic.foreign import cloud_and_shape
from primfit.synthetic.recipes import PERTURBATIONS, SENSORS, SHAPES, ForeignRecipe

FEW = 12


@pytest.mark.parametrize("name", CASE_SETS)
def test_cases_depend_on_seed_and_index_only(name):
    chosen = CASE_SETS[name]
    cases = [chosen.draw(5, index) for index in range(FEW)]
    again = chosen.draw(5, FEW - 1)
    assert np.array_equal(cases[-1].points, again.points) and cases[-1].groups == again.groups
    assert not np.array_equal(cases[0].points, chosen.draw(6, 0).points)
    for index, case in enumerate(cases):
        assert case.name == str(index) and np.isfinite(case.points).all()
        assert {group: level in chosen.description.groups[group] for group, level in case.groups.items()} == {
            group: True for group in chosen.description.groups
        }


@pytest.mark.parametrize("name", [name for name in CASE_SETS if name != "foreign"])
def test_most_points_lie_near_the_truth(name):
    cases = [CASE_SETS[name].draw(1, index) for index in range(FEW)]
    for case in (case for case in cases if case.truth):
        points = case.surface_points - case.points.mean(axis=0)
        truth = case.truth.transformed(np.eye(3), -case.points.mean(axis=0), 1.0)
        extent = np.linalg.norm(np.ptp(points, axis=0))
        assert np.median(np.abs(truth.signed_distance(points))) < 0.05 * extent


def test_the_proportions_are_those_of_the_test_set():
    """925 clouds: 100 of A0 to A8 each, 25 of A9, 185 of each kind."""
    drawn = [turn(index, KINDS, TEST_SET) for index in range(CASE_SETS["shrec"].full)]
    counts = Counter(perturbation for _, _, perturbation in drawn)
    assert counts == {name: 25 if name == "A9" else 100 for name in PERTURBATIONS}
    assert Counter(kind for kind, _, _ in drawn) == dict.fromkeys(KINDS, 185)
    small = Counter(perturbation for _, _, perturbation in drawn[: CASE_SETS["shrec"].small])
    assert small == {name: 5 if name == "A9" else 20 for name in PERTURBATIONS}


def test_levels_take_turns_on_the_same_pieces():
    assert [turn(index, ("a", "b"), (1, 2)) for index in range(6)] == [
        ("a", 0, 1),
        ("b", 1, 1),
        ("a", 0, 2),
        ("b", 1, 2),
        ("a", 2, 1),
        ("b", 3, 1),
    ]


def test_every_run_holds_every_level_alike():
    for name, levels, kinds in (
        ("outliers", OUTLIERS, 5),
        ("arcs", ARCS, 4),
        ("exact-share", EXACT, 5),
        ("sizes", SIZES, 5),
        ("coordinates", COORDINATES, 10),
        ("ambiguity", PAIR_GROUPS, 2),
        ("bias", OBJECTS, len(ROUND) * len(NOISE_LAWS)),
    ):
        chosen = CASE_SETS[name]
        assert chosen.small % (len(levels) * kinds) == 0, name
        assert chosen.full % (len(levels) * kinds) == 0, name


def test_the_share_of_outliers_is_as_asked():
    case = CASE_SETS["outliers"].draw(1, 5 * OUTLIERS.index(40))
    assert case.groups == {"outliers [%]": 40} and len(case.points) == 2000
    assert 0.4 <= case.outliers.mean() < 0.5  # mixed pixels come to it
    assert len(case.surface_points) == np.count_nonzero(~case.outliers)


def test_the_share_of_exact_points_is_as_asked():
    for level in (2, 30, 100):
        case = CASE_SETS["exact-share"].draw(1, 5 * EXACT.index(level) + 1)
        exact = np.abs(case.truth.signed_distance(case.points)) < 1e-12
        assert 100 * exact.mean() == pytest.approx(level, abs=0.1)


def test_sizes_are_as_asked():
    cases = [CASE_SETS["sizes"].draw(1, index) for index in range(5 * 3)]
    assert [len(case.points) for case in cases] == [20] * 5 + [50] * 5 + [100] * 5
    assert all(len(case.outliers) == len(case.points) for case in cases)


def test_coordinates_are_those_of_files_and_maps():
    plain, single, rounded, far = (CASE_SETS["coordinates"].draw(1, 5 * level + 1) for level in range(4))
    assert np.abs(plain.points.mean(axis=0)).max() < 1e-9
    assert np.array_equal(single.points, single.points.astype(np.float32))
    assert not np.array_equal(plain.points, single.points)
    assert np.allclose(rounded.points / 1e-3, np.round(rounded.points / 1e-3), atol=1e-9)
    assert np.allclose(far.points - plain.points, [1e7, -1e7, 1e7], atol=1e-8, rtol=0)
    for case in (single, rounded, far):
        assert np.allclose(case.truth.center - plain.truth.center, np.round(case.points - plain.points)[0])


def test_near_degenerate_shapes_are_what_they_are_called():
    cases = {
        case.groups["shape"]: case for case in (CASE_SETS["near-degenerate"].draw(1, i) for i in range(6))
    }
    assert np.degrees(cases["cone of 1 degree"].truth.half_angle) == pytest.approx(1.0)
    torus = cases["torus with R = 20 r"].truth
    assert torus.major_radius == pytest.approx(20 * torus.minor_radius)
    for name, degrees in (("sphere cap of 5 degrees", 5), ("huge sphere, cap of 1 degree", 1)):
        sphere, points = cases[name].truth, cases[name].surface_points
        reach = np.linalg.norm(np.ptp(points, axis=0)) / sphere.radius
        assert reach < 1.6 * np.radians(degrees)  # a square about the cap, and noise


def test_foreign_shapes_have_no_truth():
    case = CASE_SETS["foreign"].draw(1, 0)
    assert case.truth is None and case.kind == "foreign" and case.groups["shape"] == "ellipsoid"
    assert set(CASE_SETS["foreign"].description.groups["shape"]) == set(SHAPES)


def test_foreign_shapes_are_grouped_by_noise_or_by_what_parts_bow_by():
    """In whichever is larger: what is within one of them is not asked to be none of the kinds."""
    for index in range(FEW):
        drawn, shape = cloud_and_shape(ForeignRecipe(1), index)
        off = off_every_kind(shape) / np.linalg.norm(np.ptp(shape, axis=0))
        scales = min(off * drawn.extent / drawn.noise, off / BOW)
        found = CASE_SETS["foreign"].draw(1, index).groups["deviation"]
        assert found == ("over 3" if scales > 3 else "1 to 3" if scales > 1 else "under 1")


@pytest.mark.parametrize(("name", "share"), [("scans-0.3", 0.003), ("scans-2", 0.02)])
def test_scans_have_the_noise_that_their_set_says(name, share):
    """Along the ray; along the normal it is less. A turn changes the diagonal of the bounding box."""
    for index in range(len(KINDS)):
        case = CASE_SETS[name].draw(2, index)
        points = case.surface_points - case.points.mean(axis=0)
        truth = case.truth.transformed(np.eye(3), -case.points.mean(axis=0), 1.0)
        extent = np.linalg.norm(np.ptp(feet(truth, points), axis=0))
        assert case.noise == pytest.approx(share * extent, rel=0.4)
        assert 0.3 * case.noise < np.sqrt(np.mean(truth.signed_distance(points) ** 2)) < 1.2 * case.noise


@pytest.mark.parametrize("pair", PAIRS_OF[INDISTINGUISHABLE])
def test_a_pair_is_as_far_apart_as_its_gain_says(pair):
    """Whoever knows noise and both surfaces gains g +- sqrt(2 g) a cloud, and Phi(sqrt(g / 2)) are right."""
    rng, gain, clouds = np.random.default_rng(3), GAINS[INDISTINGUISHABLE], 300
    gains = []
    for _ in range(clouds // 2):
        simpler, other, points, noise = draw_pair(rng, pair, INDISTINGUISHABLE)
        assert PAIR_NOISE.low <= noise / np.linalg.norm(np.ptp(points, axis=0)) <= PAIR_NOISE.high
        for truth, rival in ((simpler, other), (other, simpler)):
            cloud = feet(truth, points)
            cloud += noise * rng.standard_normal((len(cloud), 1)) * truth.gradient(cloud)
            squares = rival.signed_distance(cloud) ** 2 - truth.signed_distance(cloud) ** 2
            gains.append(np.sum(squares) / (2 * noise**2))
    assert np.mean(gains) == pytest.approx(gain, abs=4 * np.sqrt(2 * gain / clouds))
    assert np.mean(np.array(gains) > 0) == pytest.approx(0.588, abs=4 * np.sqrt(0.25 / clouds))


@pytest.mark.parametrize("pair", PAIRS)
def test_clear_pairs_are_no_bow_apart(pair):
    """Three times what parts bow by, and by a gain of 500: N D^2 / (2 s^2)."""
    rng = np.random.default_rng(4)
    for _ in range(20):
        simpler, _, points, noise = draw_pair(rng, pair, CLEAR)
        apart = np.sqrt(np.mean(simpler.signed_distance(points) ** 2))
        assert apart >= 3 * BOW * np.linalg.norm(np.ptp(points, axis=0))
        assert len(points) * apart**2 / (2 * noise**2) == pytest.approx(GAINS[CLEAR])


@pytest.mark.parametrize("level", GAINS)
def test_surfaces_of_pairs_show_what_they_are_a_piece_of(level):
    """Radii of up to 5 extents, and tori that do not meet themselves."""
    rng = np.random.default_rng(5)
    for pair in PAIRS_OF[level]:
        for _ in range(10):
            _, other, points, _ = draw_pair(rng, pair, level)
            assert largest_radius(other) <= LARGEST_RADIUS * np.linalg.norm(np.ptp(points, axis=0))
            assert not isinstance(other, Torus) or other.major_radius >= other.minor_radius


def test_of_pairs_that_nobody_can_tell_the_simpler_kind_is_the_truth():
    cases = [CASE_SETS["ambiguity"].draw(1, index) for index in range(2 * len(PAIR_GROUPS))]
    for index, case in enumerate(cases):
        simpler, other = case.groups["pair"].removesuffix(", clear").split(" or ")
        drawn_from_other = index % 2 == 1
        clear = case.groups["the pair is"] == CLEAR
        assert case.kind == (other if clear and drawn_from_other else simpler)
        # Within the noise, and what the surfaces differ by where they hardly do.
        assert np.std(case.truth.signed_distance(case.points)) == pytest.approx(case.noise, rel=0.4)


@pytest.mark.parametrize(("law", "spread"), [("along the normal", [0, 0, 1]), ("isotropic", [1, 1, 1])])
def test_noise_has_the_size_and_the_directions_that_it_says(law, spread):
    """Of one place of a sphere, ten thousand times."""
    drawn = noisy(
        np.random.default_rng(0), Sphere([0, 0, 0], 1.0), np.tile([1.0, 0, 0], (10_000, 1)), 0.01, law
    )
    variances = np.linalg.eigvalsh(np.cov(drawn.points.T))
    assert variances / 1e-4 == pytest.approx(spread, abs=6 * np.sqrt(2 / 10_000))
    for case in (CASE_SETS["bias"].draw(1, index) for index in range(8)):
        assert case.noise == BIAS_NOISE * case.truth.radius and len(case.points) == 1000
        assert np.std(case.truth.signed_distance(case.points)) == pytest.approx(case.noise, rel=0.15)


def test_pieces_of_120_degrees_are_as_wide_as_they_say():
    for index in range(2, 4):
        case = CASE_SETS["bias"].draw(1, index)
        assert case.groups == {"noise": "along the normal", "object": "of 120 degrees"}
        outward = case.truth.gradient(case.points)
        middle = outward.mean(axis=0) / np.linalg.norm(outward.mean(axis=0))
        assert np.degrees(np.arccos(np.min(outward @ middle))) == pytest.approx(60.0, abs=4.0)


def test_sensors_are_grouped_by_points_and_by_sensor():
    cases = [CASE_SETS["sensor"].draw(1, index) for index in range(20)]
    assert {case.kind for case in cases} == set(KINDS)
    bounds = dict(
        zip(CASE_SETS["sensor"].description.groups["points"], (200, 1000, 5000, 20_000, np.inf), strict=True)
    )
    for case in cases:
        assert len(case.points) <= bounds[case.groups["points"]]
        assert case.groups["sensor"] in SENSORS and case.noise > 0.0
        assert np.mean(case.outliers) < 0.25
