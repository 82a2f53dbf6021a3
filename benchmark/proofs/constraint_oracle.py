"""Optima under constraints, by trying which of the bounds act; nothing here is shared with `fitting`.

Constraints are plain values as in a request: {"radius": {"value": 5.0}}, {"radius": {"min": 4.0}},
{"axis": {"direction": [0, 0, 1], "max_angle": 0.1}}, {"apex": [1.0, 2.0, 3.0]}.
"""

import itertools
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from .oracles import Array, Surface, distances, long

Constraints = dict[str, Any]
Build = Callable[[Array], Surface]

SLACK = 1e-12
"""Of an angle that is at its limit."""


def shifted(constraints: Constraints, by: Array) -> Constraints:
    """The same constraints after a translation."""
    return {
        name: (np.array(asked) + by).tolist() if isinstance(asked, list) else asked
        for name, asked in constraints.items()
    }


def violations(surface: Surface, constraints: Constraints) -> dict[str, float]:
    """How far each constraint is from being honoured, by name: radians for directions, else relative."""
    return {name: _violation(surface, name, asked) for name, asked in constraints.items()}


def _violation(surface: Surface, name: str, asked: Any) -> float:
    value = surface[name]
    if name in ("axis", "normal"):
        wanted = np.array(asked["direction"]) / np.linalg.norm(asked["direction"])
        angle = np.arctan2(_length(np.cross(value, wanted)), abs(float(value @ wanted)))
        return max(0.0, float(angle) - asked.get("max_angle", 0.0))
    if isinstance(asked, list):
        size = float(np.linalg.norm(asked))
        leaves = np.array(asked) - value
        if name == "point" and "normal" in surface:
            return abs(float(leaves @ surface["normal"])) / size
        if name == "point":
            leaves = leaves - (leaves @ surface["axis"]) * surface["axis"]
        return _length(leaves) / size
    low, high = (asked.get(end, asked.get("value", other)) for end, other in (("min", 0.0), ("max", np.inf)))
    return max(0.0, float(low - value) / low if low else 0.0, float(value - high) / high)


def _length(vector: Any) -> float:
    return float(np.sqrt(np.sum(vector * vector)))


def optimum(
    kind: str,
    constraints: Constraints,
    truth: Surface,
    points: Array,
    loss: Any = "linear",
    scale: float = 1.0,
) -> float:
    """The least cost by scipy in other coordinates: an axis by two angles about the reference or by three
    numbers, positions by three, and each bound either at its value or, if the constraints hold, away.

    Cost is half the sum of squares, or of the loss as `scipy.optimize.least_squares` has it. Points are to be
    near the origin.
    """
    best, far = np.inf, points.astype(np.longdouble)
    for fixed in _active(constraints):
        build, start = chart(fixed, truth)
        solved = least_squares(
            lambda x, build=build: distances(kind, build(x), far).astype(np.float64),
            start, loss=loss, f_scale=scale, x_scale="jac", method="trf", ftol=1e-15, xtol=1e-15, gtol=1e-15,
            max_nfev=300,
        )  # fmt: skip
        if solved.cost < best and max(violations(_unit(build(solved.x)), constraints).values()) <= SLACK:
            best = float(solved.cost)
    return best


def _active(constraints: Constraints) -> Iterator[Constraints]:
    """What acts, each bound in turn at its value or away."""
    choices: list[list[Constraints]] = []
    for name, asked in constraints.items():
        if isinstance(asked, list) or "value" in asked:
            choices.append([{name: asked}])
        elif "direction" in asked:
            choices.append([{name: asked}] + [{}] * (asked.get("max_angle", 0.0) > 0.0))
        else:
            limits = [{name: {"value": limit}} for limit in asked.values()]
            choices.append([{}, *limits])
    for chosen in itertools.product(*choices):
        yield {name: asked for one in chosen for name, asked in one.items()}


def _unit(surface: Surface) -> Surface:
    """With directions of length 1."""
    return {
        name: value / np.sqrt(np.sum(value * value)) if name in ("axis", "normal") else value
        for name, value in surface.items()
    }


def chart(fixed: Constraints, truth: Surface) -> tuple[Build, Array]:
    """A map from free numbers to a surface whose fixed parts are at their limits, and a start for it."""
    start: list[float] = []
    makers: dict[str, Callable[[Array], Any]] = {}
    for name, true in truth.items():
        value = np.asarray(true, np.float64)
        asked, at = fixed.get(name), len(start)
        if asked is None:
            start += np.atleast_1d(value).tolist()
            makers[name] = partial(_free, at=at, shape=value.shape)
        elif "direction" in asked:
            makers[name], first = _about(asked, value, at)
            start += first
        else:
            makers[name] = partial(_given, np.array(asked if isinstance(asked, list) else asked["value"]))
    return lambda x: long({name: make(x) for name, make in makers.items()}), np.array(start)


def _free(x: Array, at: int, shape: tuple[int, ...]) -> Array:
    return x[at : at + 3] if shape else x[at]


def _given(value: Array, x: Array) -> Array:
    return value


def _about(asked: dict[str, Any], value: Array, at: int) -> tuple[Callable[[Array], Array], list[float]]:
    """A direction at its largest angle from the reference, as it depends on one number; or the reference."""
    reference = np.array(asked["direction"]) / np.linalg.norm(asked["direction"])
    reference = reference * (1.0 if reference @ value >= 0.0 else -1.0)
    angle = asked.get("max_angle", 0.0)
    if not angle:
        return lambda x: reference, []
    u = np.cross(reference, np.eye(3)[np.argmin(np.abs(reference))])
    u /= np.linalg.norm(u)
    v = np.cross(reference, u)
    across = np.cos(angle), np.sin(angle)

    def direction(x: Array) -> Array:
        aside = np.cos(x[at]) * u + np.sin(x[at]) * v
        return np.asarray(across[0] * reference + across[1] * aside)

    return direction, [float(np.arctan2(value @ v, value @ u))]
