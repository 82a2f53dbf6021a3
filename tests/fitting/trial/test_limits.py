"""Constraints are honored to the last digits, and the rest is optimal."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from primfit.benchmark.proofs import oracles
from primfit.benchmark.proofs.constraint_oracle import optimum, shifted, violations
from primfit.fitting.cloud.frame import Frame
from primfit.fitting.guesses.oriented import Oriented
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import Constraints
from primfit.fitting.solver.refine import refine
from primfit.fitting.trial.limits import Limits, moved
from tests.fitting.clouds import EXAMPLES, Array, noisy
from tests.fitting.constrained import CASES, CLOUDS, FAR, IDS, SIGMA, TRUTH, constraints_of, direction, fit

BUILD: dict[str, Callable[..., Primitive]] = {
    "plane": Plane, "sphere": Sphere, "cylinder": Cylinder, "cone": Cone, "torus": Torus
}  # fmt: skip


def check_honored(found: Primitive, constraints: dict[str, Any]) -> None:
    """Numbers, centers and apexes to the last bit; directions and points on axes and planes to 1e-12."""
    for name, by in violations(oracles.long(parameters(found)), constraints).items():
        assert by <= (1e-12 if name in ("axis", "normal", "point") else 0.0), name


def least(kind: str, constraints: dict[str, Any], loss: Any = "linear", scale: float = 1.0) -> float:
    """The least cost by scipy, as seen from `FAR`."""
    truth, points = oracles.long(parameters(EXAMPLES[kind])), CLOUDS[kind] - FAR
    return optimum(kind, shifted(constraints, -FAR), truth, points, loss, scale)


def drawn(primitive: Primitive, rng: np.random.Generator) -> dict[str, Any]:
    """Random constraints on about half of the parameters, off the truth by several times what noise does."""
    constraints: dict[str, Any] = {}
    for name, value in parameters(primitive).items():
        if name == "kind" or rng.random() < 0.45:
            continue
        if name in ("axis", "normal"):
            angle = float(rng.choice([0.0, 1e-9, 1e-5, 1e-3, 0.02, 0.06, 0.3]))
            constraints[name] = {"direction": list(value + rng.normal(0.0, 0.05, 3)), "max_angle": angle}
        elif isinstance(value, float):
            low, high = np.sort(value * (1.0 + rng.normal(0.0, 0.05, 2))).tolist()
            constraints[name] = [{"value": low}, {"min": low}, {"max": low}, {"min": low, "max": high}][
                rng.integers(4)
            ]
        else:
            constraints[name] = list(value + rng.normal(0.0, 0.03, 3))
    return constraints


@pytest.mark.parametrize(("kind", "parts"), CASES, ids=IDS)
def test_a_constraint_is_honored_and_the_rest_is_optimal(kind: str, parts: dict[str, Any]) -> None:
    constraints = constraints_of(kind, parts)
    answer = fit(kind, constraints)
    assert answer.primitive is not None
    check_honored(answer.primitive, constraints)
    cost = 0.5 * float(np.sum(moved(answer.primitive, -FAR).signed_distance(CLOUDS[kind] - FAR) ** 2))
    assert cost == pytest.approx(least(kind, constraints), rel=1e-8)
    assert set(answer.active_constraints) == set(constraints)
    assert not any("not active" in how for how in answer.active_constraints.values())


@pytest.mark.parametrize(("kind", "parts"), CASES, ids=IDS)
def test_a_robust_fit_honors_it_too(kind: str, parts: dict[str, Any]) -> None:
    """A tenth of the points are stray; the others decide, as closely as their noise lets them."""
    constraints = constraints_of(kind, parts)
    points = CLOUDS[kind].copy()
    points[::10] += np.random.default_rng(5).uniform(-1.0, 1.0, points[::10].shape)
    answer = fit(kind, constraints, "robust", points=points)
    assert answer.primitive is not None
    check_honored(answer.primitive, constraints)
    plain = fit(kind, constraints)
    assert plain.primitive is not None and plain.error is not None
    kept = np.delete(np.arange(300), slice(None, None, 10))
    distances = (each.signed_distance(CLOUDS[kind][kept]) for each in (answer.primitive, plain.primitive))
    robust, best = (float(np.sqrt(np.mean(each**2))) for each in distances)
    assert robust <= 1.05 * best


@pytest.mark.parametrize(
    ("kind", "parts"), [CASES[i] for i in (3, 5, 13, 17, 23)], ids=[IDS[i] for i in (3, 5, 13, 17, 23)]
)
def test_the_optimum_under_a_kernel_is_that_of_scipy(kind: str, parts: dict[str, Any]) -> None:
    """Tukey's biweight in units of the noise, whose cut-off of 6 scales is scipy's scale here."""
    constraints = constraints_of(kind, parts)
    limits = Limits.of(Constraints.of(constraints), kind, Frame(FAR, 1.0))
    assert limits is not None
    start = fit(kind, constraints).primitive
    assert start is not None
    points = CLOUDS[kind] - FAR
    found = refine(
        moved(start, -FAR - limits.pivot), points - limits.pivot, Kernel.TUKEY, SIGMA, bounds=limits.bounds
    )

    def biweight(z: Array) -> Array:
        inside = np.maximum(1.0 - z, 0.0)
        return np.array([(1.0 - inside**3) / 3.0, inside**2, -2.0 * inside])

    expected = least(kind, constraints, biweight, 6.0 * SIGMA) / SIGMA**2
    assert found.converged
    assert found.cost == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_random_constraints_have_one_optimum_wherever_the_steps_start(kind: str) -> None:
    rng = np.random.default_rng([6, list(EXAMPLES).index(kind)])
    truth = EXAMPLES[kind]
    for trial in range(30):
        constraints = drawn(truth, rng)
        limits = Limits.of(Constraints.of(constraints), kind, Frame(np.zeros(3), 1.0))
        if limits is None:
            continue
        cloud = noisy(truth, 200, 0.02, seed=trial)
        guesses = np.array([moved(truth, by).row() for by in rng.normal(0.0, 0.03, (3, 3))])
        starts = limits.guesses(guesses, Oriented(cloud, truth.gradient(cloud)), rng)[:3]
        ends = [
            refine(BUILD[kind].from_row(row), cloud - limits.pivot, bounds=limits.bounds)
            for row in starts  # type: ignore[attr-defined]
        ]
        assert all(end.converged for end in ends)
        assert max(end.cost for end in ends) <= (1.0 + 1e-9) * min(end.cost for end in ends)
        for end in ends:
            check_honored(moved(end.primitive, limits.pivot), constraints)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_constraints_that_hold_anyway_change_nothing(kind: str) -> None:
    loose: dict[str, dict[str, Any]] = {
        "plane": {"normal": direction(0.01, 0.3)},
        "sphere": {"radius": {"min": 0.5, "max": 3.0}},
        "cylinder": {"radius": {"min": 0.5, "max": 3.0}, "axis": direction(0.01, 0.3)},
        "cone": {"half_angle": {"max": 1.2}, "axis": direction(0.01, 0.3)},
        "torus": {"major_radius": {"min": 1.0}, "minor_radius": {"max": 1.0}, "axis": direction(0.01, 0.3)},
    }
    constraints = {
        name: asked(getattr(TRUTH[kind], name)) if callable(asked) else asked
        for name, asked in loose[kind].items()
    }
    free, bound = fit(kind, {}), fit(kind, constraints)
    assert free.primitive is not None and bound.primitive is not None and free.error and bound.error
    assert bound.error.rms == pytest.approx(free.error.rms, rel=1e-12)
    assert all("not active" in how for how in bound.active_constraints.values())
    assert set(bound.active_constraints) == set(constraints)


def test_a_short_arc_of_known_radius_is_found_among_outliers() -> None:
    """30 degrees of a cylinder with a fifth of stray points: the radius that the caller knows settles it."""
    rng = np.random.default_rng(11)
    pipe = Cylinder(rng.normal(size=3), 10 * rng.normal(size=3), 5.0)
    points = pipe.surface(rng.uniform(0, np.pi / 6, 500), rng.uniform(-4, 4, 500))
    points += rng.normal(0.0, 0.05, points.shape)
    points[:100] = rng.uniform(points.min(axis=0) - 1, points.max(axis=0) + 1, (100, 3))
    errors = {}
    for name, constraints in {"free": {}, "known": {"radius": {"value": 5.0}}}.items():
        found = fit("cylinder", constraints, "robust", points=points).primitive
        assert isinstance(found, Cylinder)
        off = found.point - pipe.point
        errors[name] = float(np.linalg.norm(off - (off @ pipe.axis) * pipe.axis))
    assert errors["known"] < 0.1 < errors["free"]


def test_exact_points_stay_exact_under_a_true_constraint() -> None:
    points = noisy(EXAMPLES["torus"], 600, 0.0)
    points[::3] += np.random.default_rng(2).normal(0.0, 0.1, points[::3].shape)
    answer = fit("torus", {"center": EXAMPLES["torus"].center.tolist()}, "robust", points=points)  # type: ignore[attr-defined]
    assert isinstance(answer.primitive, Torus) and answer.error is not None
    assert answer.primitive.major_radius == pytest.approx(1.6, abs=1e-13)
    assert answer.noise.exact_share == pytest.approx(2 / 3, abs=0.01)


def test_other_kinds_are_left_free() -> None:
    config = Config(("plane", "sphere"), constraints=Constraints.of({"radius": {"value": 1.3}}))
    answer = recognize(CLOUDS["plane"], config)
    assert answer.primitive is not None and answer.primitive.kind == "plane"
    assert answer.active_constraints == {"radius": "not applicable: a plane has no radius"}
    tried = next(attempt for attempt in answer.attempts if attempt.kind == "sphere")
    assert isinstance(tried.primitive, Sphere) and tried.primitive.radius == 1.3


def test_everything_may_be_fixed() -> None:
    constraints = {"center": TRUTH["sphere"].center.tolist(), "radius": {"value": 1.3}}  # type: ignore[attr-defined]
    answer = fit("sphere", constraints)
    assert isinstance(answer.primitive, Sphere)
    assert parameters(answer.primitive) == {"kind": "sphere", "center": constraints["center"], "radius": 1.3}
    assert answer.active_constraints == {"radius": "fixed at 1.3", "center": "fixed"}


def test_the_uncertainty_of_what_is_fixed_is_none() -> None:
    constraints = {"center": TRUTH["sphere"].center.tolist(), "radius": {"value": 1.3}}  # type: ignore[attr-defined]
    known = fit("sphere", constraints).uncertainty
    assert known is not None and known.covariance is not None
    assert not known.covariance.any()
    assert {interval.method for interval in known.intervals.values()} == {"held"}


def test_three_points_and_a_known_normal_are_a_plane() -> None:
    points = [[0.0, 0.0, 0.001], [1.0, 0.0, 0.0], [0.0, 1.0, -0.001]]
    constraints = Constraints.of({"normal": {"direction": [0, 0, 1]}})
    answer = recognize(points, Config(kinds=("plane",), constraints=constraints))  # type: ignore[arg-type]
    assert answer.primitive is not None
    np.testing.assert_array_equal(answer.primitive.normal, [0.0, 0.0, 1.0])  # type: ignore[attr-defined]
