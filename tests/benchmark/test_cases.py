"""The case sets: what they say they are, and the same for the same seed."""

from collections import Counter

import numpy as np
import pytest

from benchmark.cases import ARCS, CASE_SETS, COORDINATES, EXACT, OUTLIERS, SIZES, TEST_SET, turn
from fitting.primitives import KINDS
from synthetic.recipes import PERTURBATIONS

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
    for index in range(FEW):
        case = CASE_SETS[name].draw(1, index)
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
    assert case.truth is None and case.kind == "foreign" and case.groups == {"shape": "ellipsoid"}
