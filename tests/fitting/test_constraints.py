"""Constraints are honoured to the last digits and the rest is optimal; weights count as they should."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from primfit.benchmark.proofs import oracles
from primfit.benchmark.proofs.constraint_oracle import chart, optimum, shifted, violations
from primfit.fitting.answer.result import Recognition
from primfit.fitting.cloud.frame import Frame
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import EXTREME, Config
from primfit.fitting.request.constraints import Constraints, Range
from primfit.fitting.request.guess import guess_of
from primfit.fitting.solver.refine import refine
from primfit.fitting.trial.limits import Limits, moved
from tests.fitting.clouds import EXAMPLES, Array, noisy

FAR = np.array([3e3, -2e3, 1e3])
"""Where the clouds stand: the frame of the search is never that of the input."""
SIGMA = 0.01
TRUTH = {kind: moved(primitive, FAR) for kind, primitive in EXAMPLES.items()}
CLOUDS = {kind: noisy(primitive, 300, SIGMA) + FAR for kind, primitive in EXAMPLES.items()}

BUILD: dict[str, Callable[..., Primitive]] = {
    "plane": Plane, "sphere": Sphere, "cylinder": Cylinder, "cone": Cone, "torus": Torus
}  # fmt: skip


def tilted(direction: Array, by: float) -> Array:
    """A direction that makes this angle [rad] with a given one."""
    across = np.cross(direction, [0.3, 0.5, -0.8])
    return np.cos(by) * direction + np.sin(by) * across / np.linalg.norm(across)


def number(factor: float, which: str = "value") -> Callable[[Any], Any]:
    return lambda value: {which: value * factor}


def direction(off: float, max_angle: float = 0.0, sign: float = 1.0) -> Callable[[Any], Any]:
    return lambda value: {"direction": list(sign * tilted(value, off)), "max_angle": max_angle}


def position(*by: float) -> Callable[[Any], Any]:
    return lambda value: list(value + np.array(by))


CASES: list[tuple[str, dict[str, Callable[[Any], Any]]]] = [
    ("plane", {"normal": direction(0.004)}),
    ("plane", {"normal": direction(0.004, 0.002)}),
    ("plane", {"point": position(0.004, 0.0, 0.003)}),
    ("plane", {"normal": direction(0.02, 0.002), "point": position(0.004, 0.0, 0.003)}),
    ("sphere", {"radius": number(1.01)}),
    ("sphere", {"radius": number(0.99, "max")}),
    ("sphere", {"center": position(0.005, 0.003, -0.01)}),
    ("cylinder", {"radius": number(0.99)}),
    ("cylinder", {"radius": number(1.01, "min")}),
    ("cylinder", {"axis": direction(0.01, sign=-1.0)}),
    ("cylinder", {"axis": direction(0.03, 0.02)}),
    ("cylinder", {"axis": direction(0.03, 1e-4)}),
    ("cylinder", {"point": position(0.01, -0.01, 0.0)}),
    ("cylinder", {"axis": direction(0.02, 0.01), "radius": number(1.01), "point": position(0.01, 0, 0)}),
    ("cone", {"half_angle": number(1.02)}),
    ("cone", {"half_angle": number(0.98, "max")}),
    ("cone", {"axis": direction(0.01)}),
    ("cone", {"axis": direction(0.03, 0.02, sign=-1.0)}),
    ("cone", {"apex": position(0.01, 0.02, 0.0)}),
    ("cone", {"apex": position(0.01, 0.02, 0.0), "half_angle": number(1.02)}),
    ("cone", {"apex": position(0.01, 0.02, 0.0), "axis": direction(0.02, 0.01)}),
    ("torus", {"major_radius": number(0.99)}),
    ("torus", {"minor_radius": number(1.01)}),
    ("torus", {"major_radius": number(0.99, "max"), "minor_radius": number(1.02, "min")}),
    ("torus", {"axis": direction(0.005)}),
    ("torus", {"axis": direction(0.01, 0.005)}),
    ("torus", {"center": position(0.005, 0.0, -0.005)}),
    ("torus", {"center": position(0.005, 0.0, -0.005), "axis": direction(0.01, 0.005)}),
]
IDS = [f"{kind}-{'-'.join(parts)}-{i}" for i, (kind, parts) in enumerate(CASES)]


def constraints_of(kind: str, parts: dict[str, Callable[[Any], Any]]) -> dict[str, Any]:
    return {name: make(getattr(TRUTH[kind], name)) for name, make in parts.items()}


def fit(kind: str, constraints: dict[str, Any], criterion: str = "least_squares", **data: Any) -> Recognition:
    points = data.pop("points", CLOUDS[kind])
    config = Config((kind,), criterion, constraints=Constraints.of(constraints))  # type: ignore[arg-type]
    return recognize(points, config, **data)


def check_honoured(found: Primitive, constraints: dict[str, Any]) -> None:
    """Numbers, centres and apexes to the last bit; directions and points on axes and planes to 1e-12."""
    for name, by in violations(oracles.long(parameters(found)), constraints).items():
        assert by <= (1e-12 if name in ("axis", "normal", "point") else 0.0), name


def least(kind: str, constraints: dict[str, Any], loss: Any = "linear", scale: float = 1.0) -> float:
    """The least cost by scipy, as seen from `FAR`."""
    truth, points = oracles.long(parameters(EXAMPLES[kind])), CLOUDS[kind] - FAR
    return optimum(kind, shifted(constraints, -FAR), truth, points, loss, scale)


@pytest.mark.parametrize(("kind", "parts"), CASES, ids=IDS)
def test_a_constraint_is_honoured_and_the_rest_is_optimal(kind: str, parts: dict[str, Any]) -> None:
    constraints = constraints_of(kind, parts)
    answer = fit(kind, constraints)
    assert answer.primitive is not None
    check_honoured(answer.primitive, constraints)
    cost = 0.5 * float(np.sum(moved(answer.primitive, -FAR).signed_distance(CLOUDS[kind] - FAR) ** 2))
    assert cost == pytest.approx(least(kind, constraints), rel=1e-8)
    assert set(answer.active_constraints) == set(constraints)
    assert not any("not active" in how for how in answer.active_constraints.values())


@pytest.mark.parametrize(("kind", "parts"), CASES, ids=IDS)
def test_a_robust_fit_honours_it_too(kind: str, parts: dict[str, Any]) -> None:
    """A tenth of the points are stray; the others decide, as closely as their noise lets them."""
    constraints = constraints_of(kind, parts)
    points = CLOUDS[kind].copy()
    points[::10] += np.random.default_rng(5).uniform(-1.0, 1.0, points[::10].shape)
    answer = fit(kind, constraints, "robust", points=points)
    assert answer.primitive is not None
    check_honoured(answer.primitive, constraints)
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
        starts = limits.guesses(guesses, cloud, truth.gradient(cloud), rng)[:3]
        ends = [
            refine(BUILD[kind].from_row(row), cloud - limits.pivot, bounds=limits.bounds)
            for row in starts  # type: ignore[attr-defined]
        ]
        assert all(end.converged for end in ends)
        assert max(end.cost for end in ends) <= (1.0 + 1e-9) * min(end.cost for end in ends)
        for end in ends:
            check_honoured(moved(end.primitive, limits.pivot), constraints)


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


def test_an_initial_guess_joins_the_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without any start of its own the search comes from the guess, in input units, to the same end."""
    expected = fit("cylinder", {})
    monkeypatch.setattr(Cylinder, "initial_guesses", classmethod(lambda *_: np.empty((0, 9))))
    assert fit("cylinder", {}).primitive is None
    guess = Cylinder(tilted(TRUTH["cylinder"].axis, 0.2), FAR, 1.2)  # type: ignore[attr-defined]
    guided = recognize(CLOUDS["cylinder"], Config(("cylinder",), "least_squares", initial_guess=guess))
    assert expected.error is not None and guided.error is not None
    assert guided.error.rms == pytest.approx(expected.error.rms, rel=1e-12)


@pytest.mark.parametrize(
    ("guess", "field", "said"),
    [
        (5, "initial_guess", "primitive"),
        ({"kind": "egg"}, "initial_guess.kind", "'egg'"),
        ({"kind": "sphere", "center": [0, 0, 0]}, "initial_guess", "kind, center, radius"),
        ({"kind": "sphere", "center": [0, 0], "radius": 1}, "initial_guess.center", "2 numbers"),
        ({"kind": "sphere", "center": [0, 0, 0], "radius": -1}, "initial_guess.radius", "-1"),
        ({"kind": "plane", "normal": [0, 0, 0], "point": [0, 0, 0]}, "initial_guess.normal", "zero"),
        (
            {"kind": "cone", "apex": [0, 0, 0], "axis": [0, 0, 1], "half_angle": 2},
            "initial_guess.half_angle",
            "pi/2",
        ),
    ],
)
def test_bad_guesses_are_named(guess: Any, field: str, said: str) -> None:
    with pytest.raises(InvalidOptionError) as caught:
        guess_of(guess)
    assert caught.value.field == field
    assert said in str(caught.value)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_a_guess_in_plain_values_is_the_primitive(kind: str) -> None:
    read, given = (parameters(each) for each in (guess_of(parameters(EXAMPLES[kind])), EXAMPLES[kind]))
    assert list(read) == list(given)
    assert read.pop("kind") == given.pop("kind")
    assert all(read[name] == pytest.approx(value, rel=1e-15) for name, value in given.items())


@pytest.mark.parametrize(
    ("constraints", "field", "said"),
    [
        ({"radius": {"value": -1.0}}, "constraints.radius.value", "-1"),
        ({"radius": {"value": np.nan}}, "constraints.radius.value", "nan"),
        ({"radius": {"value": 1, "min": 1}}, "constraints.radius", "either"),
        ({"radius": {}}, "constraints.radius", "either"),
        ({"radius": {"min": 3, "max": 2}}, "constraints.radius", "min 3 over the max 2"),
        ({"radius": {"low": 3}}, "constraints.radius", "'low'"),
        ({"radius": 5}, "constraints.radius", "mapping"),
        ({"radius": {"value": "5"}}, "constraints.radius.value", "not a number"),
        ({"half_angle": {"value": 1.6}}, "constraints.half_angle", "pi/2"),
        ({"axis": {"direction": [0, 0, 0]}}, "constraints.axis.direction", "zero"),
        ({"axis": {"direction": [0, 1]}}, "constraints.axis.direction", "2 numbers"),
        ({"axis": {"direction": [0, 1, np.inf]}}, "constraints.axis.direction", "inf"),
        ({"axis": {"direction": [0, 0, 1], "max_angle": 2}}, "constraints.axis.max_angle", "pi/2"),
        ({"axis": {"max_angle": 0.1}}, "constraints.axis", "direction"),
        ({"axis": [0, 0, 1]}, "constraints.axis", "mapping"),
        ({"center": [1, 2]}, "constraints.center", "2 numbers"),
        ({"center": 3.0}, "constraints.center", "[x, y, z]"),
        ({"tip": [1, 2, 3]}, "constraints", "apex"),
        ([1], "constraints", "mapping"),
    ],
)
def test_bad_constraints_are_named(constraints: Any, field: str, said: str) -> None:
    with pytest.raises(InvalidOptionError) as caught:
        Constraints.of(constraints)
    assert caught.value.field == field
    assert said in str(caught.value)


def test_a_constraint_that_no_allowed_kind_has_is_refused() -> None:
    with pytest.raises(InvalidOptionError, match=r"apex.*cylinder, sphere; cone have it") as caught:
        Config(("cylinder", "sphere"), constraints=Constraints.of({"apex": [0, 0, 0]}))
    assert caught.value.field == "constraints.apex"
    with pytest.raises(InvalidOptionError, match="initial_guess is a cone"):
        Config(("cylinder",), initial_guess=EXAMPLES["cone"])


def test_what_is_built_by_hand_is_checked_too() -> None:
    with pytest.raises(InvalidOptionError, match="mapping"):
        Constraints(radius=5.0)  # type: ignore[arg-type]
    with pytest.raises(InvalidOptionError, match="min 3 over the max 2"):
        Constraints(radius=Range(3.0, 2.0))
    with pytest.raises(InvalidOptionError, match=r"Constraints\.of"):
        Config(constraints={"radius": {"value": 5}})  # type: ignore[arg-type]
    with pytest.raises(InvalidOptionError, match="not a primitive"):
        Config(initial_guess=5)  # type: ignore[arg-type]
    given = {
        "radius": {"min": 1.0},
        "axis": {"direction": [0.0, 0.0, 2.0], "max_angle": 0.1},
        "apex": [1.0, 2.0, 3.0],
    }
    assert Constraints.of(given).plain() == given


WEIGHTS = np.random.default_rng(9).uniform(0.2, 5.0, 300)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_weighted_least_squares_is_that_of_scipy(kind: str) -> None:
    points = CLOUDS[kind] - FAR
    build, start = chart({}, oracles.long(parameters(EXAMPLES[kind])))
    solved = least_squares(
        lambda x: np.sqrt(WEIGHTS) * oracles.distances(kind, build(x), points).astype(float),
        start, x_scale="jac", ftol=1e-15, xtol=1e-15, gtol=1e-15,
    )  # fmt: skip
    for given in ({"weights": WEIGHTS}, {"standard_deviations": 7.0 / np.sqrt(WEIGHTS)}):
        found = fit(kind, {}, points=points, **given).primitive
        assert found is not None
        assert 0.5 * np.sum(WEIGHTS * found.signed_distance(points) ** 2) == pytest.approx(
            solved.cost, rel=1e-10
        )


@pytest.mark.parametrize("criterion", ["robust", "least_squares"])
def test_equal_weights_are_none(criterion: str) -> None:
    points = CLOUDS["cylinder"]
    expected = fit("cylinder", {}, criterion, points=points)
    assert expected.primitive is not None
    for given in ({"weights": np.full(300, 3.0)}, {"standard_deviations": np.full(300, 0.01)}):
        found = fit("cylinder", {}, criterion, points=points, **given)
        assert found.primitive is not None
        assert parameters(found.primitive) == parameters(expected.primitive)


@pytest.mark.parametrize("criterion", ["robust", "least_squares"])
def test_a_weight_of_zero_leaves_a_point_out_and_a_factor_changes_nothing(criterion: str) -> None:
    weights = WEIGHTS.copy()
    weights[::4] = 0.0
    points, kept = CLOUDS["cone"].copy(), weights > 0.0
    points[::4] += 5.0
    expected = fit("cone", {}, criterion, points=points[kept], weights=weights[kept])
    found = fit("cone", {}, criterion, points=points, weights=weights)
    assert found.primitive is not None and expected.primitive is not None
    assert parameters(found.primitive) == parameters(expected.primitive)
    assert found.n_points == kept.sum()
    scaled = fit("cone", {}, criterion, points=points, weights=2.0**20 * weights).primitive
    assert scaled is not None
    assert parameters(scaled) == parameters(found.primitive)


def test_weights_follow_the_points_of_a_large_cloud() -> None:
    """Half of 40,000 points have ten times the noise, and say so: the answer is as good as theirs allows."""
    rng = np.random.default_rng(1)
    truth = Sphere([1.0, 2.0, 3.0], 2.0)
    points = truth.surface(rng.uniform(0, 1, 40_000), rng.uniform(0.2, 1, 40_000))
    sigma = np.where(rng.random(40_000) < 0.5, 0.2, 0.002)
    points += sigma[:, None] * rng.normal(size=points.shape)
    radii = {}
    for name, given in {"plain": {}, "weighted": {"standard_deviations": sigma}}.items():
        found = fit("sphere", {}, points=points, **given).primitive
        assert isinstance(found, Sphere)
        radii[name] = abs(found.radius - 2.0)
    assert radii["weighted"] < 5e-3 < radii["plain"]


@pytest.mark.parametrize(
    ("given", "field", "said"),
    [
        ({"weights": np.ones(5)}, "weights", r"\(300,\) is needed"),
        ({"weights": -np.ones(300)}, r"weights[0]", "-1"),
        ({"weights": np.full(300, np.nan)}, r"weights[0]", "nan"),
        ({"weights": np.eye(300)[0]}, "weights", "1 points have a weight over zero"),
        ({"weights": ["a"] * 300}, "weights", "numbers"),
        ({"standard_deviations": np.zeros(300)}, "standard_deviations[0]", "is 0"),
        ({"standard_deviations": np.ones(300), "weights": np.ones(300)}, "weights", "not both"),
    ],
)
def test_bad_weights_are_named(given: dict[str, Any], field: str, said: str) -> None:
    with pytest.raises(InvalidPointCloudError, match=said) as caught:
        recognize(CLOUDS["sphere"], **given)
    assert caught.value.field == field


@pytest.mark.parametrize("criterion", EXTREME)
@pytest.mark.parametrize("name", ["weights", "standard_deviations"])
def test_extreme_points_take_no_weights(criterion: Any, name: str) -> None:
    with pytest.raises(InvalidPointCloudError, match=f"takes no {name}; these do: robust") as caught:
        fit("sphere", {}, criterion, **{name: np.ones(300)})
    assert caught.value.field == name


@pytest.mark.parametrize(
    ("guess", "field"),
    [
        (Sphere([0.0, 0.0, 0.0], -1.0), "initial_guess.radius"),
        (Sphere([0.0, np.nan, 0.0], 1.0), "initial_guess.center"),
        (Cone([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 2.0), "initial_guess.half_angle"),
    ],
)
def test_a_guess_built_by_hand_is_checked_too(guess: Primitive, field: str) -> None:
    with pytest.raises(InvalidOptionError) as caught:
        Config(initial_guess=guess)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("constraints", "guess", "field"),
    [
        ({"center": [1e60, 0.0, 0.0]}, None, "constraints.center"),
        ({"point": [1e99, 0.0, 0.0]}, None, "constraints.point"),
        ({"radius": {"min": 1e90}}, None, "constraints.radius"),
        ({"minor_radius": {"value": 1e20}}, None, "constraints.minor_radius"),
        ({}, Sphere([1e100, 0.0, 0.0], 1e100), "initial_guess"),
        ({}, Torus([1e50, 0.0, 0.0], [0.0, 0.0, 1.0], 1.0, 1e50), "initial_guess"),
    ],
)
@pytest.mark.parametrize("unit", [1.0, 1e-90])
def test_what_is_out_of_all_proportion_is_refused(
    constraints: dict[str, Any], guess: Primitive | None, field: str, unit: float
) -> None:
    """Every cloud lies within the rounding of a sphere whose centre is 1e60 away."""
    config = Config(constraints=Constraints.of(constraints), initial_guess=guess)
    with pytest.raises(InvalidOptionError, match="extents of the cloud") as caught:
        recognize(unit * CLOUDS["cylinder"], config)
    assert caught.value.field == field


def test_a_far_guess_fools_nobody() -> None:
    config = Config(initial_guess=Sphere([1e9, 0.0, 0.0], 1e9))
    assert isinstance(recognize(CLOUDS["cylinder"], config).primitive, Cylinder)
    assert isinstance(recognize(CLOUDS["plane"], config).primitive, Plane)
