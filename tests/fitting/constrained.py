"""Clouds far from the origin, constraints on them that are slightly off, and fits under constraints."""

from collections.abc import Callable
from typing import Any

import numpy as np

from primfit.fitting.answer.result import Recognition
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import Constraints
from primfit.fitting.trial.limits import moved
from tests.fitting.clouds import EXAMPLES, Array, noisy

FAR = np.array([3e3, -2e3, 1e3])
"""Where the clouds stand: the frame of the search is never that of the input."""
SIGMA = 0.01
TRUTH = {kind: moved(primitive, FAR) for kind, primitive in EXAMPLES.items()}
CLOUDS = {kind: noisy(primitive, 300, SIGMA) + FAR for kind, primitive in EXAMPLES.items()}


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
