"""The comparison of the kinds: bows, bars, rings, what a caller tolerates, and what each number is for."""

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from primfit.benchmark.cases import CASE_SETS
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.names import KINDS
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.verdict import judge
from primfit.fitting.verdict.judge import MISTAKEN, prior_of
from tests.fitting.pieces import ball, bar, beside_a_plane, kinds, pipe, rng, stray

Patch = pytest.MonkeyPatch


class Sure:
    """A ranking that rules out every kind but one."""

    def __init__(self, kind: str) -> None:
        self.kind = kind

    def rank(self, points: Array, normals: Array) -> Mapping[str, float]:
        return {kind: 1.0 - 4e-9 if kind == self.kind else 1e-9 for kind in KINDS}


NOISE = 0.005


class Planes:
    """Takes every cloud for a plane, with some doubt."""

    def rank(self, points: Array, normals: Array) -> Mapping[str, float]:
        return {kind: 0.9 if kind == "plane" else 0.025 for kind in KINDS}


def prism(faces: int, n: int, noise: float, seed: int) -> Array:
    """The sides of a prism along z, 2 radii long, without ends."""
    random = rng(seed)
    side, along, height = random.integers(faces, size=n), random.random(n), random.uniform(-1.0, 1.0, n)
    corners = np.exp(2j * np.pi * np.arange(faces + 1) / faces)
    places = corners[side] + along * (corners[side + 1] - corners[side])
    outward = np.exp(2j * np.pi * (side + 0.5) / faces)
    places = places + noise * random.normal(size=n) * outward
    return np.column_stack([places.real, places.imag, height])


def test_a_cone_on_a_short_arc_may_be_a_cylinder(monkeypatch: Patch) -> None:
    """`DECIDED`"""
    points = arc_of_a_cone()
    assert kinds(recognize(points)) == ["cylinder", "cone"]
    monkeypatch.setattr(judge, "DECIDED", 0.0)
    assert kinds(recognize(points)) == ["cylinder"]


def test_a_ranking_that_is_never_mistaken_makes_an_arc_a_plane(monkeypatch: Patch) -> None:
    """`MISTAKEN`"""
    points = pipe(300, 0.005, 18, arc=0.6)
    assert kinds(recognize(points, classifier=Sure("plane"))) == ["cylinder"]
    monkeypatch.setattr(judge, "MISTAKEN", 1e-12)
    assert kinds(recognize(points, classifier=Sure("plane"))) == ["plane"]


def test_an_exact_rod_of_forty_faces_passes_for_round_and_one_of_six_does_not(monkeypatch: Patch) -> None:
    """`FORM`"""
    fine, coarse = bar(40, 3000, 0.0, 19), bar(6, 3000, 0.0, 19)
    assert kinds(recognize(fine)) == ["cylinder"] and kinds(recognize(coarse)) == []
    monkeypatch.setattr(judge, "FORM", 0.0)
    assert kinds(recognize(fine)) == []
    monkeypatch.setattr(judge, "FORM", 0.1)
    assert kinds(recognize(coarse)) == ["cylinder"]


def test_a_filled_cube_is_no_surface(monkeypatch: Patch) -> None:
    """`SCATTER`"""
    points = rng(20).uniform(-1.0, 1.0, (1500, 3))
    assert kinds(recognize(points)) == []
    monkeypatch.setattr(judge, "SCATTER", np.inf)
    assert kinds(recognize(points))


def test_a_third_of_the_points_on_a_plane_is_a_second_surface(monkeypatch: Patch) -> None:
    """`PART`"""
    points = beside_a_plane(pipe(1500, 0.005, 22), 0.35, 0.005, 22)
    assert kinds(recognize(points)) == []
    monkeypatch.setattr(judge, "PART", 0.4)
    assert kinds(recognize(points)) == ["cylinder"]


def test_a_few_strewn_points_in_a_row_are_no_second_surface(monkeypatch: Patch) -> None:
    """`PART`"""
    points = stray(pipe(1500, 0.005, 23), 0.5, 23)
    assert kinds(recognize(points)) == ["cylinder"]
    monkeypatch.setattr(judge, "PART", 0.0)
    assert kinds(recognize(points)) == []


def test_some_exact_points_more_do_not_make_a_ball_a_torus(monkeypatch: Patch) -> None:
    """`EQUAL_SHARES`: among points that are moved by some steps a torus finds more that it passes through."""
    points = ball(600, 0.0, 25)
    points[:300] += rng(25).uniform(-0.002, 0.002, (300, 3))
    points = np.round(points, 3)
    assert kinds(recognize(points)) == ["sphere"]
    monkeypatch.setattr(judge, "EQUAL_SHARES", 0.0)
    assert kinds(recognize(points)) == ["torus"]


@pytest.mark.parametrize("n", [400, 3000, 20_000])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_plane_that_bows_by_half_its_noise_may_be_one(n: int, sign: float) -> None:
    x, y = rng(n).uniform(-0.5, 0.5, (2, n))
    bow = x**2 + y**2
    bow = sign * 0.5 * NOISE * (bow - bow.mean()) / bow.std()
    points = np.column_stack([x, y, bow + NOISE * rng(1).normal(size=n)])
    answers = [recognize(points, classifier=Planes())]
    if n < 20_000:  # so many points alone speak for the sphere that a dome is
        answers.append(recognize(points))
    for answer in answers:
        kinds = [answer.primitive, *(other.primitive for other in answer.alternatives)]
        assert any(isinstance(each, Plane) for each in kinds)
        assert len(kinds) <= 2


@pytest.mark.parametrize("faces", [3, 4, 5, 6, 8])
@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_a_bar_is_no_cylinder(faces: int, noise: float) -> None:
    answer = recognize(prism(faces, 3000, noise, faces))
    assert answer.status == "no_fit"
    assert recognize(prism(faces, 3000, noise, faces), Config(kinds=("cylinder",))).status == "no_fit"


def test_a_pipe_beside_the_bars_is_one() -> None:
    pipe = Cylinder([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 1.0)
    points = pipe.surface(rng(0).uniform(0.0, 2.0 * np.pi, 3000), rng(1).uniform(-1.0, 1.0, 3000))
    answer = recognize(points + 0.003 * rng(2).normal(size=(3000, 3)))
    assert answer.status == "fitted" and isinstance(answer.primitive, Cylinder)


def test_two_rings_do_not_decide_for_the_sphere_through_them() -> None:
    cone = Cone([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.5)
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    points = np.vstack([cone.surface(angle, np.full(40, height)) for height in (1.0, 2.0)])
    answer = recognize(points)
    assert answer.status == "ambiguous" and answer.primitive is not None
    kinds = {answer.primitive.kind, *(other.primitive.kind for other in answer.alternatives)}
    assert {"sphere", "cone"} <= kinds
    for other in answer.alternatives:
        assert other.error.max < 1e-9


def test_a_lattice_of_coordinates_has_planes_that_are_no_surface() -> None:
    """A plane holds 29% of these points to the last digit; the pipe, in the same steps, is nearer to all."""
    x, y = (each.ravel() for each in np.meshgrid(np.arange(-50.0, 51.0, 2.0), np.arange(-50.0, 51.0, 2.0)))
    answer = recognize(np.column_stack([x, y, np.round(np.sqrt(200.0**2 - x**2))]))
    assert answer.status == "fitted" and isinstance(answer.primitive, Cylinder)


def test_on_curves_a_tolerance_tells_no_more() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(40)])
    rings = np.vstack([ring, 2.0 * ring + [0.0, 0.0, 3.0]])
    assert recognize(rings).status == recognize(rings, Config(tolerance=1e-9)).status == "ambiguous"


def test_what_is_wrong_names_the_kind_that_it_is_about() -> None:
    """Of an L section the plane of one leg leaves the other; the best try may be another kind."""
    draws = rng(12)
    along = draws.uniform(0.0, 5.0, 500)
    section = np.column_stack(
        [np.minimum(along, 3.0), np.maximum(along - 3.0, 0.0), draws.uniform(-2, 2, 500)]
    )
    plane = recognize(section + 0.01 * draws.normal(size=(500, 3)), Config(kinds=("plane",)))
    assert plane.status == "no_fit" and "a second surface, away from the plane" in plane.message


def test_few_points_are_no_plane_with_a_third_thrown_away() -> None:
    pipe = Cylinder([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 1.0)
    points = pipe.surface(rng(3).uniform(0.0, np.pi, 24), rng(4).uniform(-1.0, 1.0, 24))
    answer = recognize(points + 0.02 * rng(5).normal(size=(24, 3)))
    assert answer.primitive is not None
    kinds = {answer.primitive.kind, *(other.primitive.kind for other in answer.alternatives)}
    assert "cylinder" in kinds and "plane" not in kinds


def test_repeating_points_moves_nothing_and_shares_tell_of_all_points() -> None:
    pipe = Cylinder([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 1.0)
    points = pipe.surface(rng(6).uniform(0.0, 3.0, 600), rng(7).uniform(-1.0, 1.0, 600))
    points += NOISE * rng(8).normal(size=(600, 3))
    points[:30] += rng(9).uniform(-1.0, 1.0, (30, 3))
    again = np.vstack([points, points[:200], points[:200]])
    one, two = recognize(points), recognize(again)
    assert isinstance(one.primitive, Cylinder) and isinstance(two.primitive, Cylinder)
    assert two.primitive.radius == pytest.approx(one.primitive.radius, abs=1e-9)
    assert two.inlier_rule is not None and two.error is not None
    belongs = two.inlier_rule.among(again)
    assert two.error.inlier_share == pytest.approx(belongs.mean())
    distance = two.primitive.signed_distance(again)[belongs]
    assert two.error.inlier_rms == pytest.approx(np.sqrt(np.mean(distance**2)))


def test_within_the_tolerance_the_simplest_kind_is_answered() -> None:
    ball = Sphere([0.0, 0.0, -2.0], 2.0)
    x, y = rng(10).uniform(-0.5, 0.5, (2, 3000))
    points = np.column_stack([x, y, np.sqrt(4.0 - x**2 - y**2) - 2.0]) + 1e-3 * rng(11).normal(size=(3000, 3))
    assert isinstance(recognize(points).primitive, Sphere)
    answer = recognize(points, Config(tolerance=0.1))
    assert answer.status == "fitted" and isinstance(answer.primitive, Plane)
    assert recognize(points, Config(kinds=("plane",))).status == "no_fit"
    assert recognize(points, Config(kinds=("plane",), tolerance=0.1)).status == "fitted"
    assert ball.radius == 2.0


def test_the_ranking_is_a_prior_that_may_be_mistaken() -> None:
    assert prior_of(1.0) > prior_of(None) > prior_of(0.0)
    assert np.exp(prior_of(0.0)) == pytest.approx(MISTAKEN / 5.0)


def test_attempts_carry_their_evidence_beside_that_of_the_answer() -> None:
    pipe = Cylinder([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 1.0)
    points = pipe.surface(rng(12).uniform(0.0, 2.0, 800), rng(13).uniform(-1.0, 1.0, 800))
    answer = recognize(points + NOISE * rng(14).normal(size=(800, 3)))
    evidence = {attempt.kind: attempt.evidence for attempt in answer.attempts}
    assert evidence["cylinder"] == 0.0
    assert evidence["cone"] is not None and evidence["cone"] < 0.0


@pytest.mark.parametrize("seed", range(3))
def test_probabilities_before_the_evidence_are_those_of_a_law(seed: int) -> None:
    """They sum to 1 for any ranking, and keep its order."""
    ranking = np.sort(np.random.default_rng(seed).dirichlet(np.full(len(KINDS), 0.3)))
    priors = np.array([prior_of(probability) for probability in ranking])
    assert np.exp(priors).sum() == pytest.approx(1.0)
    assert (np.diff(priors) >= 0.0).all()
    assert len(KINDS) * np.exp(prior_of(None)) == pytest.approx(1.0)


def arc_of_a_cone(noise: float = 0.002) -> Array:
    """Short enough for a cylinder to fit nearly as well."""
    cone = Cone(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.3)
    points = cone.surface(rng(17, 0).uniform(-0.15, 0.15, 1000), rng(17, 1).uniform(1.0, 2.0, 1000))
    return np.asarray(points + noise * rng(17, 2).normal(size=points.shape))


@pytest.mark.parametrize(("noise", "alternatives"), [(0.0005, 0), (0.002, 1), (0.004, 0)])
def test_kinds_are_told_apart_from_20_to_1(noise: float, alternatives: int) -> None:
    answer = recognize(arc_of_a_cone(noise))
    as_likely = {
        attempt.kind
        for attempt in answer.attempts
        if attempt.evidence is not None and 1.0 < np.exp(-attempt.evidence) < np.exp(3.0)
    }
    assert {other.primitive.kind for other in answer.alternatives} == as_likely
    assert len(as_likely) == alternatives and answer.status == ("ambiguous" if alternatives else "fitted")


def test_the_more_noise_the_simpler_the_kind() -> None:
    """What does not show any more is not answered: the angle of the cone first, and then its curvature."""
    answers = [recognize(arc_of_a_cone(noise)).primitive for noise in (0.0003, 0.004, 0.01)]
    assert [answer.kind for answer in answers if answer] == ["cone", "cylinder", "plane"]


@pytest.mark.parametrize("make", [arc_of_a_cone, lambda: pipe(600, 0.005, 4), lambda: ball(600, 0.005, 7)])
def test_the_order_in_which_kinds_are_allowed_changes_nothing(make: Callable[[], Array]) -> None:
    points = make()
    one, other = recognize(points), recognize(points, Config(kinds=KINDS[::-1]))
    assert (one.status, kinds(one)) == (other.status, kinds(other))
    assert one.primitive is not None and other.primitive is not None
    assert (
        np.abs(one.primitive.signed_distance(points) - other.primitive.signed_distance(points)).max() < 1e-9
    )


def test_kinds_that_hold_the_best_surface_are_not_searched_for_in_vain() -> None:
    """Noise that neighbors share leaves more than white noise; a taper or a bend does not explain it."""
    cases = [CASE_SETS["sensor"].draw(4711, index) for index in range(20)]
    answers = [recognize(case.points, classifier=Sure(case.kind)) for case in cases]
    assert np.mean([len(answer.attempts) for answer in answers]) < 2.0


@pytest.mark.parametrize("index", [22, 50])
def test_a_cone_on_a_short_arc_is_searched_for_beside_a_likelier_cylinder(index: int) -> None:
    """A taper shows within the patches, which reach half across the arc."""
    answer = recognize(CASE_SETS["arcs"].draw(4711, index).points, classifier=Sure("cylinder"))
    assert answer.attempts[0].kind == "cylinder"
    assert kinds(answer) == ["cone"]
