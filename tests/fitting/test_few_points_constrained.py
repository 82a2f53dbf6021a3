"""What is fixed needs no points: the fewest points, the noise and the choice of a kind count what is free."""

from typing import Any

import numpy as np
import pytest

from primfit.fitting.answer.result import Recognition
from primfit.fitting.cloud.frame import Frame
from primfit.fitting.errors import InvalidPointCloudError
from primfit.fitting.primitives import PRIMITIVES
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import Constraints
from primfit.fitting.solver.refine import refine, stepped
from primfit.fitting.trial.limits import Limits
from tests.fitting.clouds import EXAMPLES, Array, noisy, sample
from tests.fitting.constrained import CASES, IDS

KNOWN: list[tuple[str, tuple[str, ...], int]] = [
    ("plane", ("normal",), 1),
    ("sphere", ("radius",), 3),
    ("sphere", ("center",), 1),
    ("sphere", ("center", "radius"), 0),
    ("cylinder", ("axis",), 3),
    ("cylinder", ("axis", "radius"), 2),
    ("cylinder", ("point", "radius"), 2),
    ("cylinder", ("axis", "point", "radius"), 0),
    ("cone", ("apex",), 3),
    ("cone", ("axis", "half_angle"), 3),
    ("torus", ("center", "axis"), 2),
    ("torus", ("major_radius", "minor_radius"), 5),
]
"""A kind, what is known of it, and how many parameters that leaves free."""
known = pytest.mark.parametrize(("kind", "names", "free"), KNOWN)


def constraints_of(kind: str, names: tuple[str, ...]) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for name in names:
        value = getattr(EXAMPLES[kind], name)
        if name in ("axis", "normal"):
            made[name] = {"direction": list(value)}
        else:
            made[name] = {"value": value} if isinstance(value, float) else list(value)
    return made


def fit(
    points: Array, kinds: tuple[str, ...], constraints: dict[str, Any], criterion: str = "robust"
) -> Recognition:
    config = Config(kinds, criterion, constraints=Constraints.of(constraints))  # type: ignore[arg-type]
    return recognize(points, config)


@known
def test_as_many_points_as_are_free_determine_it(kind: str, names: tuple[str, ...], free: int) -> None:
    constraints, fewest = constraints_of(kind, names), max(free, 3)
    points = sample(EXAMPLES[kind], fewest, seed=2)
    answer = fit(points, (kind,), constraints)
    assert answer.status == "fitted" and answer.primitive is not None
    assert np.abs(answer.primitive.signed_distance(points)).max() < 1e-12
    assert answer.uncertainty is not None
    minimal = "minimal_sample" in [warning.code for warning in answer.uncertainty.warnings]
    assert minimal == (free >= 3)
    if free > 3:
        with pytest.raises(InvalidPointCloudError, match=f"within these constraints needs at least {free}"):
            fit(points[1:], (kind,), constraints)


@known
def test_the_noise_is_estimated_from_what_is_left(kind: str, names: tuple[str, ...], free: int) -> None:
    points = noisy(EXAMPLES[kind], max(free, 3) + 3, 1e-3)
    answer = fit(points, (kind,), constraints_of(kind, names))
    assert answer.primitive is not None and answer.noise is not None
    squares = float(np.sum(answer.primitive.signed_distance(points) ** 2))
    assert answer.noise.scale == pytest.approx(np.sqrt(squares / (len(points) - free)), rel=1e-9)


def test_an_active_bound_holds_a_parameter() -> None:
    points = noisy(EXAMPLES["sphere"], 8, 1e-3)
    answer = fit(points, ("sphere",), {"radius": {"max": 1.29}})
    assert answer.primitive is not None and answer.noise is not None
    squares = float(np.sum(answer.primitive.signed_distance(points) ** 2))
    assert answer.noise.scale == pytest.approx(np.sqrt(squares / (8 - 3)), rel=1e-9)


@pytest.mark.parametrize(("kind", "parts"), CASES, ids=IDS)
@pytest.mark.parametrize("seed", range(2))
def test_few_points_have_the_cheapest_minimum(kind: str, parts: dict[str, Any], seed: int) -> None:
    """None of the minima that refinement reaches from thirty starts about the truth is cheaper."""
    truth, rng = EXAMPLES[kind], np.random.default_rng(seed)
    constraints = {name: make(getattr(truth, name)) for name, make in parts.items()}
    limits = Limits.of(Constraints.of(constraints), kind, Frame(np.zeros(3), 1.0))
    assert limits is not None
    points = noisy(
        truth,
        int(rng.integers(max(PRIMITIVES[kind].dof - np.count_nonzero(limits.frozen), 3) + 1, 31)),
        0.02,
        100 + seed,
    )
    found = fit(points, (kind,), constraints, "least_squares").primitive
    assert found is not None
    steps = rng.normal(size=(30, truth.dof)) * np.linspace(0.0, 1.0, 30)[:, None]
    starts = (limits.impose(stepped(truth, step).row(), points - limits.pivot) for step in steps)
    ends = [
        refine(PRIMITIVES[kind].from_row(row), points - limits.pivot, bounds=limits.bounds)
        for row in starts
        if np.isfinite(row).all()
    ]
    best = min(end.cost for end in ends if end.converged)
    assert 0.5 * np.sum(found.signed_distance(points) ** 2) <= best * (1.0 + 1e-8)


def test_a_section_determines_a_cylinder_of_known_axis() -> None:
    pipe = EXAMPLES["cylinder"]
    axis = constraints_of("cylinder", ("axis",))
    section = pipe.surface(np.linspace(0.0, 2.0, 20), np.full(20, 0.3))  # type: ignore[attr-defined]
    found = fit(section, ("cylinder",), axis).primitive
    assert found is not None and found.radius == pytest.approx(0.8, abs=1e-12)  # type: ignore[attr-defined]
    with pytest.raises(InvalidPointCloudError, match="at least 5"):
        fit(section[:4], ("cylinder",), {})
    assert "one plane" in fit(section, ("cylinder",), {}).message


@pytest.mark.parametrize("criterion", ["robust", "least_squares"])
@pytest.mark.parametrize("n", [3, 8, 60])
def test_points_of_a_plane_along_the_axis_do_not(criterion: str, n: int) -> None:
    across, along = np.random.default_rng(n).uniform(size=(2, n))
    flat = np.stack([across, across, along], axis=1)
    answer = fit(flat, ("cylinder",), {"axis": {"direction": [0, 0, 1]}}, criterion)
    assert answer.status == "no_fit" and "lie in one plane" in answer.message


def test_a_known_radius_tells_a_cylinder_from_a_cone() -> None:
    for seed in range(10):
        points = noisy(EXAMPLES["cylinder"], 40, 0.01, seed)
        answer = fit(points, ("cylinder", "cone"), constraints_of("cylinder", ("radius",)))
        assert answer.status == "fitted" and answer.primitive is not None
        assert answer.primitive.kind == "cylinder"


def test_a_known_axis_makes_no_cylinder_of_a_plane() -> None:
    """It would have as few free parameters, and may be as flat."""
    points, axis = noisy(EXAMPLES["plane"], 60, 0.01), np.cross(EXAMPLES["plane"].normal, [1.0, 0.0, 0.0])  # type: ignore[attr-defined]
    answer = fit(points, ("plane", "cylinder"), {"axis": {"direction": list(axis)}})
    assert answer.status == "fitted" and answer.primitive is not None and answer.primitive.kind == "plane"
    assert answer.active_constraints == {"axis": "not applicable: a plane has no axis"}
