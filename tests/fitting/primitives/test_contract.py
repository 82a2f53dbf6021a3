"""The contract that every primitive keeps (STYLE of the family: one suite over all members)."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from primfit.fitting.cloud.frame import Frame
from primfit.fitting.guesses.oriented import Oriented
from primfit.fitting.names import KINDS
from primfit.fitting.primitives import PRIMITIVES, parameters
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.solver.refine import linearize, refine, stepped
from tests.fitting.clouds import EXAMPLES, noisy, rotation, sample

ROUNDING = 1e-14
"""A few dozen units in the last place of coordinates near 1."""

examples = pytest.mark.parametrize("primitive", EXAMPLES.values(), ids=EXAMPLES.keys())


def around(n: int = 60) -> np.ndarray:
    return np.random.default_rng(5).normal(0.0, 1.4, (n, 3))


def same_surface(a: Primitive, b: Primitive, points: np.ndarray, tolerance: float) -> None:
    np.testing.assert_allclose(a.signed_distance(points), b.signed_distance(points), rtol=0, atol=tolerance)


def test_every_primitive_has_an_example() -> None:
    assert tuple(EXAMPLES) == KINDS == tuple(PRIMITIVES)


@examples
def test_samples_lie_on_the_surface(primitive: Primitive) -> None:
    assert np.abs(primitive.signed_distance(sample(primitive, 500))).max() < ROUNDING


@examples
def test_the_outer_side_is_positive(primitive: Primitive) -> None:
    points = sample(primitive, 100)
    outward = points + 0.1 * primitive.gradient(points)
    np.testing.assert_allclose(primitive.signed_distance(outward), 0.1, atol=1e-12)


@examples
def test_distance_is_orthogonal_and_gradient_has_length_one(primitive: Primitive) -> None:
    points = around()
    gradient = primitive.gradient(points)
    np.testing.assert_allclose(np.linalg.norm(gradient, axis=1), 1.0, atol=1e-12)
    feet = points - primitive.signed_distance(points)[:, None] * gradient
    assert np.abs(primitive.signed_distance(feet)).max() < 1e-12
    for point, slope in zip(points[:20], gradient[:20], strict=True):
        numeric = approx_fprime(point, lambda x: float(primitive.signed_distance(x[None])[0]), 1e-7)
        np.testing.assert_allclose(slope, numeric, atol=1e-5)


@examples
def test_distance_is_the_smallest_to_a_dense_sample(primitive: Primitive) -> None:
    """A slow oracle that knows no formula but the surface's own points, in a part that holds all feet."""
    rng = np.random.default_rng(8)
    on_surface = sample(primitive, 40_000)
    inner = sample(primitive, 400, seed=3)
    center = inner[np.argsort(np.linalg.norm(inner - inner.mean(axis=0), axis=1))[:40]]
    points = center + rng.normal(0.0, 0.02, center.shape)
    brute = np.linalg.norm(points[:, None] - on_surface, axis=2).min(axis=1)
    # The closest of 40,000 random points is within about 0.03 sideways of the foot.
    assert np.abs(np.hypot(primitive.signed_distance(points), 0.0) - brute).max() < 0.03


@examples
def test_jacobian_equals_finite_differences(primitive: Primitive) -> None:
    points = around()
    distance, jacobian = linearize(primitive, points)
    np.testing.assert_allclose(distance, primitive.signed_distance(points), atol=ROUNDING)
    assert jacobian.shape == (len(points), primitive.dof)
    for column in range(primitive.dof):
        step = np.zeros(primitive.dof)
        step[column] = 1e-6
        forward, backward = (stepped(primitive, s * step).signed_distance(points) for s in (1.0, -1.0))
        # Central differences of step 1e-6: truncation 1e-12, cancellation 1e-10, curvature near an axis more.
        np.testing.assert_allclose(jacobian[:, column], (forward - backward) / 2e-6, atol=1e-7)


def test_jacobian_behind_the_apex_of_a_cone() -> None:
    cone = EXAMPLES["cone"]
    assert isinstance(cone, Cone)
    points = cone.apex - np.multiply.outer(np.linspace(0.2, 2.0, 30), cone.axis) + 0.05 * around(30)
    distance, jacobian = linearize(cone, points)
    np.testing.assert_allclose(distance, np.linalg.norm(points - cone.apex, axis=1), atol=ROUNDING)
    for column in range(cone.dof):
        step = 1e-6 * np.eye(cone.dof)[column]
        numeric = (
            stepped(cone, step).signed_distance(points) - stepped(cone, -step).signed_distance(points)
        ) / 2e-6
        np.testing.assert_allclose(jacobian[:, column], numeric, atol=1e-7)


@examples
def test_a_step_of_nothing_changes_nothing(primitive: Primitive) -> None:
    same_surface(primitive, stepped(primitive, np.zeros(primitive.dof)), around(), ROUNDING)


@examples
@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_moves_with_the_cloud(primitive: Primitive, scale: float) -> None:
    points, turn, shift = around(), rotation(1), scale * np.array([1.0, -2.0, 3.0])
    moved = primitive.transformed(turn, shift, scale)
    np.testing.assert_allclose(
        moved.signed_distance(scale * points @ turn.T + shift),
        scale * primitive.signed_distance(points),
        atol=100.0 * scale * ROUNDING,
    )


@examples
def test_canonical_is_the_same_surface_in_one_sign(primitive: Primitive) -> None:
    canonical = primitive.canonical(np.array([0.4, 0.3, -0.2]))
    assert parameters(canonical.canonical(np.array([0.4, 0.3, -0.2]))).keys() == parameters(primitive).keys()
    np.testing.assert_allclose(
        np.abs(canonical.signed_distance(around())),
        np.abs(primitive.signed_distance(around())),
        atol=ROUNDING,
    )
    flipped = {"plane": "normal", "cylinder": "axis", "torus": "axis"}.get(primitive.kind)
    if flipped:
        values = {name: getattr(primitive, name) for name in parameters(primitive) if name != "kind"}
        opposite = type(primitive)(**{**values, flipped: -values[flipped]})
        np.testing.assert_allclose(
            getattr(opposite.canonical(np.zeros(3)), flipped), getattr(canonical, flipped), atol=ROUNDING
        )
        assert getattr(canonical, flipped)[0] > 0.0


@examples
def test_free_points_are_those_closest_to_the_center(primitive: Primitive) -> None:
    center = np.array([0.4, 0.3, -0.2])
    canonical = primitive.canonical(center)
    if primitive.kind == "cylinder":
        assert abs((canonical.point - center) @ canonical.axis) < ROUNDING  # type: ignore[attr-defined]
    elif primitive.kind == "plane":
        across = np.cross(canonical.point - center, canonical.normal)  # type: ignore[attr-defined]
        assert np.abs(across).max() < ROUNDING


@examples
def test_least_squares_recovers_the_parameters(primitive: Primitive) -> None:
    points = sample(primitive, 300)
    frame = Frame.of(points)
    rng = np.random.default_rng(2)
    truth = primitive.transformed(np.eye(3), -frame.center, 1.0).transformed(
        np.eye(3), np.zeros(3), 1.0 / frame.scale
    )
    start = stepped(truth, 0.05 * rng.normal(size=primitive.dof))
    refined = refine(start, frame.normalize(points))
    assert refined.converged
    found = frame.restore(refined.primitive)
    same_surface(primitive.canonical(np.zeros(3)), found.canonical(np.zeros(3)), around(), 1e-11)


@examples
def test_least_squares_is_a_stationary_point_under_noise(primitive: Primitive) -> None:
    points = noisy(primitive, 400, 0.02)
    center = points.mean(axis=0)
    start = primitive.transformed(np.eye(3), -center, 1.0)
    refined = refine(start, points - center)
    distance, jacobian = linearize(refined.primitive, points - center)
    # The gradient of 400 residuals of 0.02 starts near 1; at rest only rounding is left.
    assert np.abs(jacobian.T @ distance).max() < 1e-8
    assert refined.cost <= 0.5 * float(np.sum(start.signed_distance(points - center) ** 2))


@examples
@pytest.mark.parametrize("offset", [0.0, 1e6])
@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_initial_guesses_start_close_enough(primitive: Primitive, offset: float, scale: float) -> None:
    """At least one start of a far or tiny cloud leads least squares back to the surface."""
    points = scale * sample(primitive, 160) + offset
    frame = Frame.of(points)
    cloud = frame.normalize(points)
    normals = primitive.gradient(sample(primitive, 160))
    guesses = type(primitive).initial_guesses(Oriented(cloud, normals), np.random.default_rng(0))
    assert len(guesses)
    best = min(refine(type(primitive).from_row(guess), cloud).cost for guess in guesses)
    rounding = np.spacing(offset + scale) / frame.scale
    assert best < len(cloud) * (10.0 * rounding) ** 2 + 1e-24


@examples
def test_points_on_the_axis_and_in_the_center_give_numbers(primitive: Primitive) -> None:
    special = [getattr(primitive, name) for name in ("point", "center", "apex") if hasattr(primitive, name)]
    points = np.array([*special, special[0] + 0.5 * getattr(primitive, "axis", np.zeros(3))])
    distance, jacobian = linearize(primitive, points)
    assert np.isfinite(distance).all() and np.isfinite(jacobian).all()
    assert np.isfinite(primitive.gradient(points)).all()


@examples
def test_parameters_are_plain_and_complete(primitive: Primitive) -> None:
    values = parameters(primitive)
    assert next(iter(values)) == "kind" and values.pop("kind") == primitive.kind
    assert all(isinstance(value, float) or len(value) == 3 for value in values.values())  # type: ignore[arg-type]
    rebuilt = type(primitive)(**values)
    same_surface(primitive, rebuilt, around(), ROUNDING)


@examples
def test_vectors_cannot_be_written_to(primitive: Primitive) -> None:
    name = next(name for name, value in parameters(primitive).items() if isinstance(value, list))
    with pytest.raises(ValueError, match="read-only"):
        getattr(primitive, name)[0] = 9.0


def test_a_zero_axis_is_refused() -> None:
    with pytest.raises(ValueError, match="non-zero"):
        Torus(center=[0, 0, 0], axis=[0, 0, 0], major_radius=2.0, minor_radius=1.0)


@pytest.mark.parametrize("step", [-2.0, 2.0])
def test_a_cone_survives_steps_beyond_its_range(step: float) -> None:
    cone = stepped(EXAMPLES["cone"], np.array([0.0, 0.0, 0.0, 0.0, step, 0.0]))
    assert isinstance(cone, Cone)
    assert 0.0 < cone.half_angle < np.pi / 2
    assert np.isfinite(cone.signed_distance(around())).all()


SLIGHT = 1e-4
"""Curvature, taper or share by which a surface leaves its limit."""

AXIS, ACROSS = np.eye(3)[2], np.eye(3)[0]

LIMITS: dict[str, tuple[Primitive, Primitive]] = {
    "sphere, plane": (Plane(AXIS, np.zeros(3)), Sphere(-AXIS / SLIGHT, 1.0 / SLIGHT)),
    "cylinder, plane": (
        Plane(AXIS, np.zeros(3)),
        Cylinder(np.array([0.6, 0.8, 0.0]), -AXIS / SLIGHT, 1.0 / SLIGHT),
    ),
    "torus, plane": (
        Plane(AXIS, np.zeros(3)),
        Torus(-3.0 * AXIS / SLIGHT, ACROSS, 2.0 / SLIGHT, 1.0 / SLIGHT),
    ),
    "cone, cylinder": (Cylinder(AXIS, np.zeros(3), 1.0), Cone(-AXIS / SLIGHT, AXIS, np.arctan(SLIGHT))),
    "torus, cylinder": (
        Cylinder(AXIS, np.zeros(3), 1.0),
        Torus(np.array([0.6, 0.8, 0.0]) / SLIGHT, np.array([-0.8, 0.6, 0.0]), 1.0 / SLIGHT, 1.0),
    ),
    "torus, sphere": (Sphere(np.zeros(3), 1.0), Torus(np.zeros(3), AXIS, SLIGHT, 1.0)),
}


@pytest.mark.parametrize("pair", LIMITS)
def test_kinds_leave_their_limits_by_these_bends(pair: str) -> None:
    """Hardly anything is left; a fifth beside a sphere, where harmonics of second degree stand for a sine."""
    limit, surface = LIMITS[pair]
    place = np.random.default_rng(3).uniform(-0.4, 0.4, (200, 2))
    feet = limit.surface(place[:, 0], place[:, 1] + (1.0 if isinstance(limit, Sphere) else 0.0))
    apart = surface.signed_distance(feet)
    ways = next(columns for kinds, columns in limit.bends(feet) if surface.kind in kinds)
    columns = np.hstack([linearize(limit, feet)[1], ways])
    left = apart - columns @ np.linalg.lstsq(columns, apart, rcond=None)[0]
    without = columns[:, : limit.dof]
    before = apart - without @ np.linalg.lstsq(without, apart, rcond=None)[0]
    assert np.abs(before).max() > 1e-3 * SLIGHT
    assert np.abs(left).max() < (0.2 if isinstance(limit, Sphere) else 1e-3) * np.abs(before).max()


def test_kinds_that_are_no_limits_have_no_bends() -> None:
    bent = [kind for kind, each in EXAMPLES.items() if each.bends(sample(each, 20))]
    assert bent == ["plane", "sphere", "cylinder"]
