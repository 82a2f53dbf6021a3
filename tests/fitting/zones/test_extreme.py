"""Minimum zone, minimum circumscribed and maximum inscribed surfaces, against other optimizers."""

import numpy as np
import pytest

from primfit.benchmark.proofs import oracles
from primfit.benchmark.proofs.zone_oracles import flatness, polished, smallest_sphere
from primfit.benchmark.proofs.zones import all_around
from primfit.fitting.cloud.cloud import Cloud
from primfit.fitting.cloud.frame import Frame
from primfit.fitting.errors import FailedFit, InvalidOptionError
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.zones.extreme import minimum_zone
from primfit.synthetic import ScannerRecipe
from primfit.synthetic import cloud as draw
from primfit.synthetic.recipes import Range
from tests.fitting.clouds import EXAMPLES, noisy, rotation, sample

Array = np.ndarray

examples = pytest.mark.parametrize("primitive", EXAMPLES.values(), ids=EXAMPLES.keys())
WEAK = ScannerRecipe(
    seed=77,
    points=Range(30, 3000),
    noise=Range(1e-5, 0.01),
    noiseless=0.1,
    outliers=Range(0.0, 0.0),
    without_outliers=1.0,
    arc=Range(20.0, 360.0),
    whole=0.2,
    decidable=False,
)

round_kinds = pytest.mark.parametrize("kind", ["sphere", "cylinder"])


def answer(points: Array, kind: str, criterion: str) -> Primitive:
    found = recognize(points, Config(kinds=(kind,), criterion=criterion))  # type: ignore[arg-type]
    assert found.status == "fitted" and found.primitive is not None, found.message
    return found.primitive


def largest(primitive: Primitive, points: Array) -> float:
    return float(np.abs(primitive.signed_distance(points)).max())


def about(kind: str, n: int, sigma: float, seed: int) -> Array:
    """Noisy points all around a sphere, or a cylinder as long as wide, in general position."""
    rng = np.random.default_rng(seed)
    return all_around(kind, n, sigma, rng) @ rotation(seed).T + rng.normal(size=3)


def best(found: Primitive, points: Array, criterion: str) -> float:
    """What SLSQP reaches from an answer, and from beside it."""
    start, rng = oracles.long(parameters(found)), np.random.default_rng(1)
    return polished(found.kind, oracles.near(found.kind, start, 2, rng, 0.01), points, criterion)


@pytest.mark.parametrize("seed", range(4))
def test_flatness_is_the_least_width_of_all_pairs_of_planes(seed: int) -> None:
    points = noisy(EXAMPLES["plane"], 16, 0.02, seed)
    plane = answer(points, "plane", "minimum_zone")
    width = float(np.ptp(plane.signed_distance(points)))
    assert width == pytest.approx(flatness(points), rel=1e-10)
    assert largest(plane, points) == pytest.approx(width / 2.0, rel=1e-10)


@pytest.mark.parametrize("n", [4, 5, 9, 14])
@pytest.mark.parametrize("seed", range(4))
def test_the_circumscribed_sphere_is_the_smallest_of_all(n: int, seed: int) -> None:
    points = np.random.default_rng([n, seed]).normal(size=(n, 3))
    sphere = answer(points, "sphere", "minimum_circumscribed")
    assert isinstance(sphere, Sphere)
    assert sphere.radius == pytest.approx(smallest_sphere(points), rel=1e-11)


def test_the_circumscribed_sphere_of_two_points_far_apart() -> None:
    """Two points on it, and more freedom than contacts: it takes second derivatives to come to rest."""
    points = np.vstack(
        [[[2.0, 0.0, 0.0], [-2.0, 0.0, 0.0]], np.random.default_rng(0).normal(0, 0.3, (40, 3))]
    )
    sphere = answer(points, "sphere", "minimum_circumscribed")
    assert isinstance(sphere, Sphere)
    assert sphere.radius == pytest.approx(2.0, rel=1e-12)
    np.testing.assert_allclose(sphere.center, 0.0, atol=1e-8)


@pytest.mark.parametrize("n", [10, pytest.param(40, marks=pytest.mark.slow)])
@examples
def test_the_minimum_zone_is_that_of_another_optimizer(primitive: Primitive, n: int) -> None:
    points = noisy(primitive, n, 0.02, seed=n)
    zone = answer(points, primitive.kind, "minimum_zone")
    assert largest(zone, points) <= best(zone, points, "minimum_zone") * (1.0 + 1e-9)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("n", [12, 60])
def test_the_circumscribed_cylinder_is_that_of_another_optimizer(n: int, seed: int) -> None:
    points = about("cylinder", n, 0.02, seed)
    cylinder = answer(points, "cylinder", "minimum_circumscribed")
    assert isinstance(cylinder, Cylinder)
    assert cylinder.signed_distance(points).max() < 1e-14
    assert cylinder.radius <= best(cylinder, points, "minimum_circumscribed") * (1.0 + 1e-9)


@pytest.mark.parametrize("n", [15, 60])
@round_kinds
def test_the_inscribed_surface_is_that_of_another_optimizer(kind: str, n: int) -> None:
    points = about(kind, n, 0.02, seed=n)
    inscribed = answer(points, kind, "maximum_inscribed")
    assert isinstance(inscribed, Sphere | Cylinder)
    assert inscribed.signed_distance(points).min() > -1e-14
    assert inscribed.radius >= best(inscribed, points, "maximum_inscribed") * (1.0 - 1e-9)


@round_kinds
def test_the_three_radii_hold_each_other(kind: str) -> None:
    points = about(kind, 100, 0.01, seed=5)
    inscribed, zone, circumscribed = (
        answer(points, kind, criterion)
        for criterion in ("maximum_inscribed", "minimum_zone", "minimum_circumscribed")
    )
    assert inscribed.radius < zone.radius < circumscribed.radius  # type: ignore[attr-defined]
    for other in (inscribed, circumscribed):
        assert np.ptp(zone.signed_distance(points)) <= np.ptp(other.signed_distance(points))


@pytest.mark.parametrize(("index", "kind"), [(79, "torus"), (217, "cylinder"), (328, "cone"), (239, "torus")])
def test_pieces_that_determine_a_shape_weakly_have_a_minimum_zone(index: int, kind: str) -> None:
    """Short arcs of few points with noise, whose curvature drifts far on the way to the minimum."""
    piece = draw(WEAK, index)
    zone = answer(piece.points, kind, "minimum_zone")
    assert piece.kind == kind
    frame = Frame.of(piece.points)
    points, zone = frame.normalize(piece.points), frame.bring(zone)
    assert largest(zone, points) <= best(zone, points, "minimum_zone") * (1.0 + 1e-6)


@round_kinds
def test_a_surface_that_starts_on_the_wrong_side_bends_over(kind: str) -> None:
    """The minimum zone of a shallow bowl is the same from a dome: it passes through the plane."""
    x, y = np.random.default_rng(3).uniform(-1.0, 1.0, (2, 200))
    bowl = np.stack([x, y, 0.05 * (x**2 + y**2 * (kind == "sphere"))], axis=1)
    cloud = Cloud.prepare(
        bowl + np.random.default_rng(4).normal(0.0, 0.01, bowl.shape), None, np.random.default_rng(0)
    )
    ends = []
    for z in (30.0, -30.0):
        start = (
            Sphere([0.0, 0.0, z], 30.0)
            if kind == "sphere"
            else Cylinder([0.0, 1.0, 0.0], [0.0, 0.0, z], 30.0)
        )
        end = minimum_zone([start], cloud)
        assert not isinstance(end, FailedFit), end.reason
        ends.append(largest(end, cloud.points))
    assert ends[0] == pytest.approx(ends[1], rel=1e-9)


@pytest.mark.parametrize("sigma", [1e-7, 1e-10])
@round_kinds
def test_a_surface_that_is_a_plane_to_the_last_digits_says_so(kind: str, sigma: float) -> None:
    """Its radius is so large that the distances drown in rounding, or seem to be 0."""
    x, y = np.random.default_rng(5).uniform(-1.0, 1.0, (2, 60))
    points = np.stack([x, y, np.random.default_rng(6).normal(0.0, sigma, 60)], axis=1)
    found = recognize(points, Config(kinds=(kind,), criterion="minimum_zone"))  # type: ignore[arg-type]
    assert found.status == "no_fit"
    reason = found.attempts[0].reason
    assert f"The search for the minimum zone of a {kind} did not converge" in reason
    assert "it is hardly different from a plane" in reason


@pytest.mark.parametrize("scale", [1e-6, 1e6])
@examples
def test_zones_move_and_scale_with_the_cloud(primitive: Primitive, scale: float) -> None:
    points = noisy(primitive, 80, 0.02)
    plain = largest(answer(points, primitive.kind, "minimum_zone"), points)
    moved = scale * (points @ rotation(1).T + 20.0)
    assert largest(answer(moved, primitive.kind, "minimum_zone"), moved) == pytest.approx(
        scale * plain, rel=1e-9
    )


@examples
def test_zones_far_from_the_origin(primitive: Primitive) -> None:
    points = np.round(noisy(primitive, 80, 0.02) * 2.0**20) / 2.0**20
    near, far = (
        largest(answer(each, primitive.kind, "minimum_zone").transformed(np.eye(3), -offset, 1.0), points)
        for each, offset in ((points, np.zeros(3)), (points + 2.0**20, np.full(3, 2.0**20)))
    )
    assert far == pytest.approx(near, abs=1e-8)


@examples
def test_an_exact_cloud_has_no_zone(primitive: Primitive) -> None:
    points = sample(primitive, 200)
    assert largest(answer(points, primitive.kind, "minimum_zone"), points) < 1e-13


@examples
def test_as_many_points_as_parameters_lie_on_the_surface(primitive: Primitive) -> None:
    points = sample(primitive, primitive.dof, seed=3)
    assert largest(answer(points, primitive.kind, "minimum_zone"), points) < 1e-12


def test_a_corner_of_a_cube_of_points() -> None:
    """Many more contacts than parameters."""
    axis = np.linspace(-1.0, 1.0, 5)
    points = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    sphere = answer(points, "sphere", "minimum_circumscribed")
    assert isinstance(sphere, Sphere)
    assert sphere.radius == pytest.approx(np.sqrt(3.0), rel=1e-12)
    np.testing.assert_allclose(sphere.center, 0.0, atol=1e-12)


@pytest.mark.parametrize("kind", ["sphere", "cylinder"])
def test_open_surfaces_hold_no_inscribed_one(kind: str) -> None:
    points = about(kind, 100, 0.001, seed=1)
    middle = points.mean(axis=0)
    if kind == "cylinder":
        axis = answer(points, kind, "least_squares").axis  # type: ignore[attr-defined]
        side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    else:
        side = np.array([1.0, 0.0, 0.0])
    found = recognize(
        points[(points - middle) @ side > 0.1], Config(kinds=(kind,), criterion="maximum_inscribed")
    )
    assert found.status == "no_fit" and found.primitive is None
    assert "do not enclose" in found.attempts[0].reason


def test_kinds_without_a_radius_have_no_inscribed_surface() -> None:
    with pytest.raises(InvalidOptionError, match="is for sphere or cylinder; kinds allows only plane, cone"):
        Config(kinds=("plane", "cone"), criterion="minimum_circumscribed")
    found = recognize(about("sphere", 300, 0.01, 0), Config(criterion="maximum_inscribed"))
    assert found.status == "fitted" and isinstance(found.primitive, Sphere)
    reasons = {attempt.kind: attempt.reason for attempt in found.attempts if attempt.outcome == "failed"}
    assert set(reasons) == {"plane", "cone", "torus"}
    assert reasons["cone"] == (
        "The criterion maximum_inscribed is defined for a sphere or a cylinder, not for a cone."
    )


def test_the_kind_is_found_whatever_the_criterion() -> None:
    """One stray point in a hundred spoils the minimum zone, not the choice of the kind."""
    points = noisy(EXAMPLES["cylinder"], 800, 0.005)
    points[:8] += 0.5
    for criterion in ("huber", "minimum_zone", "minimum_circumscribed"):
        found = recognize(points, Config(criterion=criterion))  # type: ignore[arg-type]
        assert found.status == "fitted" and isinstance(found.primitive, Cylinder), criterion
        assert found.error is not None and found.error.inlier_share > 0.98
        distance = found.primitive.signed_distance(points)
        assert found.error.zone == pytest.approx(float(np.ptp(distance)), rel=1e-9)


def test_a_kind_that_is_the_only_one_allowed_is_not_refused() -> None:
    """Unless by `max_error`, which is held against all points."""
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (300, 3))
    assert recognize(points, Config(kinds=("sphere",))).status == "no_fit"
    for criterion in ("least_squares", "minimum_zone"):
        found = recognize(points, Config(kinds=("sphere",), criterion=criterion))  # type: ignore[arg-type]
        assert found.status == "fitted"
        assert found.message.endswith("the sphere is answered as the only kind allowed.")
        assert found.error is not None
        for factor, status in ((0.99, "no_fit"), (1.01, "fitted")):
            limit = factor * found.error.relative_mean
            config = Config(kinds=("sphere",), criterion=criterion, max_error=limit)  # type: ignore[arg-type]
            assert recognize(points, config).status == status
