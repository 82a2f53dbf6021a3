"""The pipeline from points to an answer: right kinds, backtracking, refusals, and input that is no cloud."""

import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from primfit.benchmark.cases import CASE_SETS
from primfit.fitting.answer.result import Recognition
from primfit.fitting.errors import InvalidPointCloudError
from primfit.fitting.names import KINDS
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.search import starts
from primfit.synthetic import RECIPES, cloud
from primfit.synthetic.shrec import SyntheticCloud, batch
from tests.fitting.clouds import EXAMPLES, noisy, rotation, sample

examples = pytest.mark.parametrize("primitive", EXAMPLES.values(), ids=EXAMPLES.keys())


class Fixed:
    """Ranks the kinds in the order given, each half as probable as the one before."""

    def __init__(self, *kinds: str) -> None:
        self.kinds = kinds

    def rank(self, points: np.ndarray, normals: np.ndarray) -> Mapping[str, float]:
        weights = {kind: 0.5**place for place, kind in enumerate(self.kinds)}
        return {kind: weight / sum(weights.values()) for kind, weight in weights.items()}


class Sure:
    """Has hardly a doubt."""

    def __init__(self, kind: str) -> None:
        self.kind = kind

    def rank(self, points: np.ndarray, normals: np.ndarray) -> Mapping[str, float]:
        return {kind: 0.96 if kind == self.kind else 0.01 for kind in KINDS}


def reverse_of(kind: str) -> Fixed:
    """The worst ranking: the most general kinds first and the truth last."""
    return Fixed(*[other for other in reversed(KINDS) if other != kind], kind)


def right(cloud: SyntheticCloud, answer: Recognition) -> bool:
    return answer.status == "fitted" and answer.primitive is not None and answer.primitive.kind == cloud.kind


class TorusFirst(Sure):
    """Ranks the torus first and the plane nearly last."""

    def __init__(self) -> None:
        super().__init__("torus")

    def rank(self, points: np.ndarray, normals: np.ndarray) -> Mapping[str, float]:
        return {"plane": 0.01, "sphere": 0.03, "cylinder": 0.03, "cone": 0.03, "torus": 0.9}


@examples
@pytest.mark.parametrize("offset", [0.0, 1e6])
@pytest.mark.parametrize("scale", [1e-12, 1e-4, 1.0, 1e4, 1e9])
def test_exact_clouds_far_and_near_tiny_and_huge(primitive: Primitive, offset: float, scale: float) -> None:
    points = scale * sample(primitive, 400) + offset
    rounding = 4.0 * float(np.spacing(np.abs(points).max()))
    if rounding > 1e-5 * scale:
        pytest.skip(f"float64 cannot hold an extent of {scale:g} at {offset:g}")
    answer = recognize(points, classifier=Fixed(primitive.kind, *[k for k in KINDS if k != primitive.kind]))
    assert answer.status == "fitted" and answer.primitive is not None
    assert answer.primitive.kind == primitive.kind
    assert np.abs(answer.primitive.signed_distance(points)).max() < 20.0 * rounding


@examples
def test_answers_move_with_the_cloud(primitive: Primitive) -> None:
    points = noisy(primitive, 600, 0.005)
    turn, shift, scale = rotation(3), np.array([3.0, -5.0, 2.0]), 7.0
    plain = recognize(points, Config(kinds=(primitive.kind,))).primitive
    moved = recognize(scale * points @ turn.T + shift, Config(kinds=(primitive.kind,))).primitive
    assert plain is not None and moved is not None
    expected = plain.transformed(turn, shift, scale).canonical(scale * points.mean(axis=0) @ turn.T + shift)
    places = scale * points @ turn.T + shift
    np.testing.assert_allclose(
        np.abs(moved.signed_distance(places)), np.abs(expected.signed_distance(places)), atol=1e-6 * scale
    )


@examples
def test_noisy_clouds_are_recognized_with_every_ranking(primitive: Primitive) -> None:
    points = noisy(primitive, 1500, 0.01, seed=2)
    for classifier in (None, reverse_of(primitive.kind)):
        answer = recognize(points, classifier=classifier)
        assert answer.status == "fitted" and answer.primitive is not None
        assert answer.primitive.kind == primitive.kind
        assert answer.error is not None
        assert answer.noise.scale == pytest.approx(0.01, rel=0.1)


def test_benchmark_clouds_with_a_reversed_ranking() -> None:
    """Backtracking acts: with the truth ranked last nearly all clouds are still right and exact."""
    clouds = list(batch(seed=1901, n=30))
    answers = [recognize(cloud.points, classifier=reverse_of(cloud.kind)) for cloud in clouds]
    assert sum(map(right, clouds, answers)) >= 28
    assert np.mean([len(answer.attempts) for answer in answers]) > 3.0


def test_without_a_classifier_all_kinds_are_tried() -> None:
    answer = recognize(sample(EXAMPLES["sphere"], 300))
    assert [attempt.kind for attempt in answer.attempts] == list(KINDS)
    assert all(attempt.probability is None for attempt in answer.attempts)
    assert answer.status == "fitted" and answer.primitive is not None and answer.primitive.kind == "sphere"


def test_a_threshold_far_below_the_noise_tries_all_kinds_and_fits_none() -> None:
    points = noisy(EXAMPLES["cylinder"], 800, 0.02)
    answer = recognize(points, Config(max_error=1e-6), Fixed("cylinder", "cone", "torus", "sphere", "plane"))
    assert answer.status == "no_fit"
    assert {attempt.kind for attempt in answer.attempts} == set(KINDS)
    assert all(attempt.outcome == "refused" and "max_error" in attempt.reason for attempt in answer.attempts)
    assert answer.primitive is not None, "the best try is still returned"


def test_a_threshold_above_the_noise_accepts_the_first_kind() -> None:
    points = noisy(EXAMPLES["cylinder"], 800, 0.02)
    answer = recognize(points, Config(max_error=0.01), Fixed("cylinder", "cone", "torus", "sphere", "plane"))
    assert answer.status == "fitted"
    assert [attempt.kind for attempt in answer.attempts] == ["cylinder"]


@pytest.mark.parametrize("sigma", [0.0, 0.02])
def test_a_sphere_does_not_fit_a_cylinder(sigma: float) -> None:
    answer = recognize(noisy(EXAMPLES["cylinder"], 800, sigma), Config(kinds=("sphere",)))
    assert answer.status == "no_fit"
    assert answer.primitive is not None and answer.primitive.kind == "sphere"
    assert "deviate systematically from the sphere" in answer.message


def test_a_cone_of_a_cylinder_is_called_a_cylinder() -> None:
    points = noisy(EXAMPLES["cylinder"], 1000, 0.005)
    answer = recognize(points, classifier=Fixed("cone", "torus", "sphere", "plane", "cylinder"))
    assert answer.primitive is not None and answer.primitive.kind == "cylinder"
    cone = next(attempt for attempt in answer.attempts if attempt.kind == "cone")
    assert cone.outcome == "refused" and "cylinder" in cone.reason


def test_a_torus_without_a_hole_is_called_a_sphere() -> None:
    answer = recognize(sample(EXAMPLES["sphere"], 800), classifier=reverse_of("sphere"))
    assert answer.status == "fitted" and answer.primitive is not None and answer.primitive.kind == "sphere"


@pytest.mark.parametrize("n", [4, 5, 6, 8])
def test_minimal_sets_are_fitted_when_the_kind_is_given(n: int) -> None:
    points = sample(EXAMPLES["sphere"], n)
    answer = recognize(points, Config(kinds=("sphere",)))
    assert answer.status == "fitted" and answer.primitive is not None
    assert parameters(answer.primitive)["radius"] == pytest.approx(1.3, abs=1e-12)


@pytest.mark.parametrize("n", [3, 4, 5, 6, 7, 8, 12, 20, 30, 60])
def test_a_few_random_points_are_no_surface(n: int) -> None:
    answer = recognize(np.random.default_rng(n).normal(size=(n, 3)))
    assert answer.status == "no_fit"


@pytest.mark.parametrize("n", [5, 8, 14])
def test_a_few_noisy_points_are_fitted_when_the_kind_is_given(n: int) -> None:
    points = noisy(EXAMPLES["sphere"], n, 0.001)
    answer = recognize(points, Config(kinds=("sphere",)))
    assert answer.status == "fitted" and answer.primitive is not None
    assert parameters(answer.primitive)["radius"] == pytest.approx(1.3, abs=0.05)


@examples
def test_fifty_noisy_points_are_enough(primitive: Primitive) -> None:
    answer = recognize(noisy(primitive, 50, 0.01))
    assert answer.status == "fitted" and answer.primitive is not None
    assert answer.primitive.kind == primitive.kind


def test_a_kind_left_out_comes_back_when_the_best_one_changes() -> None:
    """Beside the torus the plane is improbable; beside the large sphere that replaces it, it is asked for."""
    rng = np.random.default_rng(0)
    points = rng.uniform(-1.0, 1.0, (1000, 3))
    points[:, 2] = rng.normal(0.0, 0.01, 1000)
    answer = recognize(points, classifier=TorusFirst())
    assert answer.status == "fitted" and answer.primitive is not None and answer.primitive.kind == "plane"


def test_a_shallow_arc_is_not_called_a_plane_at_once() -> None:
    """The sagitta of 25 degrees is five noise scales, whatever the ranking says."""
    rng = np.random.default_rng(0)
    cylinder = Cylinder(axis=[0, 0, 1], point=[0, 0, 0], radius=1.0)
    points = cylinder.surface(np.radians(rng.uniform(0, 25, 1500)), rng.uniform(-0.2, 0.2, 1500))
    points += rng.normal(0.0, 0.005, points.shape)
    answer = recognize(points, classifier=Sure("plane"))
    assert answer.status == "fitted" and answer.primitive is not None and answer.primitive.kind == "cylinder"


@pytest.mark.parametrize("kind", ["sphere", "cylinder", "cone", "torus"])
def test_coplanar_points_do_not_determine_a_curved_kind(kind: str) -> None:
    answer = recognize(sample(EXAMPLES["plane"], 200), Config(kinds=(kind,)))
    assert answer.status == "no_fit" and answer.primitive is None and answer.error is None
    assert "one plane" in answer.message


def test_a_cube_corner_and_a_blob_are_nothing() -> None:
    rng = np.random.default_rng(0)
    corner = np.concatenate([np.insert(rng.uniform(0, 1, (300, 2)), axis, 0.0, axis=1) for axis in range(3)])
    assert recognize(corner).status == "no_fit"
    assert recognize(rng.normal(size=(500, 3))).status == "no_fit"


@pytest.mark.parametrize("sigma", [0.0, 0.01])
def test_duplicated_points_change_nothing(sigma: float) -> None:
    points = np.repeat(noisy(EXAMPLES["cone"], 200, sigma), 4, axis=0)
    answer = recognize(points)
    assert answer.status == "fitted" and answer.primitive is not None and answer.primitive.kind == "cone"


def test_the_same_points_give_the_same_answer() -> None:
    points = noisy(EXAMPLES["torus"], 900, 0.01)
    first, second = recognize(points), recognize(points.copy())
    assert first.primitive is not None and second.primitive is not None
    assert parameters(first.primitive) == parameters(second.primitive)
    assert [a.reason for a in first.attempts] == [a.reason for a in second.attempts]


def test_fewer_points_than_every_allowed_kind_takes_is_an_error() -> None:
    with pytest.raises(InvalidPointCloudError, match="5 points given; a torus needs at least 7"):
        recognize(sample(EXAMPLES["torus"], 5), Config(kinds=("torus",)))


def test_the_noise_model_says_what_was_put_in() -> None:
    rng = np.random.default_rng(4)
    points = sample(EXAMPLES["sphere"], 3000)
    points[:1500] += rng.normal(0.0, 0.01, (1500, 3))
    points[1500:1800] = rng.uniform(points.min(axis=0) - 1.0, points.max(axis=0) + 1.0, (300, 3))
    noise = recognize(points).noise
    assert noise is not None
    assert noise.scale == pytest.approx(0.01, rel=0.1)
    assert noise.exact_share == pytest.approx(0.4, abs=0.01)
    assert noise.outlier_share == pytest.approx(0.1, abs=0.02)
    assert noise.quantisation_step is None
    noise = recognize(np.round(noisy(EXAMPLES["cylinder"], 2000, 0.02), 3)).noise
    assert noise is not None and noise.quantisation_step == 0.001


@pytest.mark.parametrize("step", [0.005, 0.25, 2.0])
@examples
def test_points_rounded_to_any_step_are_exact(primitive: Primitive, step: float) -> None:
    points = np.round(5000.0 * sample(primitive, 1500)) * step
    answer = recognize(points)
    assert answer.status == "fitted" and answer.primitive is not None and answer.noise is not None
    assert answer.primitive.kind == primitive.kind
    assert answer.noise.exact_share == 1.0
    assert answer.noise.quantisation_step == step


@pytest.mark.parametrize("share", [0.5, 0.7])
def test_a_surface_of_its_own_among_the_rejected_is_no_primitive(share: float) -> None:
    rng = np.random.default_rng(6)
    corner = np.concatenate(
        [
            np.insert(rng.uniform(0.0, 1.0, (round(part * 3000), 2)), axis, 0.0, axis=1)
            for axis, part in ((2, share), (1, 1.0 - share))
        ]
    )
    assert recognize(corner + rng.normal(0.0, 0.002, corner.shape)).status == "no_fit"


def test_foreign_shapes_are_nothing_and_scans_are() -> None:
    """Six shapes that are none of the kinds, in turn, and scans of those that are; all kinds are tried.

    Saddles within 0.2% of the extent of a torus are tori.
    """
    foreign = [cloud(replace(RECIPES["foreign"], seed=91), i).points for i in range(18)]
    scans = [cloud(replace(RECIPES["scanner"], seed=91), i).points for i in range(10)]
    assert sum(recognize(points).status == "no_fit" for points in foreign) >= 15
    assert sum(recognize(points).status == "no_fit" for points in scans) <= 1


def test_half_of_gross_outliers_do_not_hide_a_torus() -> None:
    rng = np.random.default_rng(7)
    points = noisy(EXAMPLES["torus"], 2000, 0.005)
    points[:1000] = rng.uniform(points.min(axis=0) - 0.5, points.max(axis=0) + 0.5, (1000, 3))
    answer = recognize(points)
    assert answer.status == "fitted" and answer.primitive is not None and answer.primitive.kind == "torus"
    assert answer.noise is not None and answer.noise.outlier_share == pytest.approx(0.5, abs=0.05)


def test_a_short_noisy_arc_of_a_cone_is_ambiguous_and_a_quiet_one_is_not() -> None:
    rng = np.random.default_rng(8)
    cone = Cone([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.6)
    arc = cone.surface(rng.uniform(0.0, 0.7, 1500), rng.uniform(1.0, 2.0, 1500))
    noise = rng.normal(size=(1500, 1)) * cone.gradient(arc)
    answer = recognize(arc + 0.015 * noise)
    assert answer.status == "ambiguous" and answer.primitive is not None
    kinds = {answer.primitive.kind, *(other.primitive.kind for other in answer.alternatives)}
    assert kinds >= {"cone", "cylinder"}
    quiet = recognize(arc + 0.001 * noise)
    assert quiet.status == "fitted" and isinstance(quiet.primitive, Cone)


@pytest.mark.parametrize("kind", KINDS)
def test_a_noisy_surface_moves_with_its_cloud_to_the_last_digits(kind: str) -> None:
    points = noisy(EXAMPLES[kind], 1500, 0.01)
    points -= points.mean(axis=0)
    turn = rotation(3)
    alone, moved = recognize(points).primitive, recognize(4.0 * points @ turn.T + 8.0).primitive
    assert alone is not None and moved is not None
    back = moved.transformed(turn.T, -2.0 * turn.T @ np.ones(3), 0.25)
    difference = np.abs(back.signed_distance(points)) - np.abs(alone.signed_distance(points))
    assert np.abs(difference).max() < 1e-12


def test_a_few_points_on_a_bent_tube_are_a_torus() -> None:
    """Normals of so few points tell nothing; the search bends cylinders."""
    rng = np.random.default_rng(4)
    for _ in range(8):
        torus = Torus(rng.normal(size=3), rng.normal(size=3), rng.uniform(8.0, 14.0), 1.0)
        points = torus.surface(rng.uniform(-0.16, 0.16, 45), rng.uniform(0.0, 2.0 * np.pi, 45))
        points += rng.normal(0.0, 4e-4, points.shape)
        answer = recognize(points)
        assert answer.status == "fitted" and isinstance(answer.primitive, Torus)
        assert answer.error is not None and answer.error.rms < 8e-4


def test_a_ball_on_the_rings_of_a_spinning_laser_is_no_cone_about_the_laser(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Noise along the ray leaves each ring on its cone: 7% of these points to the last digit.

    Whether the search for a cone comes upon it is a matter of its starts.
    """
    case = CASE_SETS["sensor"].draw(1201, 176)
    answer = recognize(case.points)
    assert answer.status == "fitted" and isinstance(answer.primitive, Sphere)
    monkeypatch.setattr(starts, "RANKING", np.array([[160, 10, 40]]))
    cone = recognize(case.points, Config(kinds=("cone",)))
    assert cone.noise is not None and cone.noise.exact_share > 0.05


def test_a_plane_that_few_points_determine_exactly_has_an_answer() -> None:
    """Whole coordinates, of which no more than three on the plane count: nothing is left over by them."""
    points = [
        [-1, 1, -1], [0, 2, 2], [-1, 0, 0], [-2, 2, 1], [0, -1, -1], [-2, 2, 0], [1, 0, 0], [2, 2, -1],
        [-2, -1, -2], [2, 2, 0], [0, 0, 0], [-2, -1, -1], [-2, 0, 0], [-1, -1, 0], [0, 1, 0],
    ]  # fmt: skip
    answer = recognize(np.array(points, np.float64), Config(kinds=("plane",)))
    assert isinstance(answer.primitive, Plane)


@pytest.mark.parametrize("seed", [7, 13, 17, 21])
def test_half_a_torus_is_found_beside_a_tenth_of_points_anywhere(seed: int) -> None:
    """Sparse ones, whose neighbors curve by more than the noise: the first search is misled."""
    rng = np.random.default_rng([7, seed])
    torus = Torus(3.0 * rng.normal(size=3), rng.normal(size=3), 1.0, 0.7)
    points = torus.surface(rng.uniform(0.0, np.pi, 100), rng.uniform(0.0, 2.0 * np.pi, 100))
    points += rng.normal(0.0, 0.01, points.shape)
    points[:10] = rng.uniform(-4.0, 4.0, (10, 3))
    answer = recognize(points, Config(kinds=("torus",)))
    assert answer.error is not None and answer.error.inlier_rms is not None
    assert answer.error.inlier_rms < 0.02


def test_a_fit_needs_no_scipy() -> None:
    """Its import takes longer than ten fits; here a third of the points may be a second surface."""
    code = (
        "import sys, numpy as np, primfit\n"
        "points = np.random.default_rng(0).uniform(-1.0, 1.0, (900, 3))\n"
        "points[:600, 2] *= 0.01\n"
        "print(primfit.fit(points).status, 'scipy' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert run.stdout == "fitted False\n"
