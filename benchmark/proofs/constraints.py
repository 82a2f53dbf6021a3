"""Constraints on noisy clouds: honoured, and the rest optimal."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.random import Generator

from primfit.fitting.primitives import parameters

from . import oracles
from .constraint_oracle import Constraints, optimum, shifted, violations
from .fits import fitted
from .parts import Part, part
from .trial import Figures, Trial

CRITERIA = ("least_squares", "robust")
MORE, ARCS, NOISE = (100, 300), (120.0, 180.0, 360.0), (-3.5, -2.5)
STRAY = 10
"""Under the robust criterion every so manieth point is stray."""
OFF = {"least_squares": (1.0, 4.0), "robust": (0.2, 1.0)}
"""How far off the truth a constraint is, in standard deviations of the noise, over the size of the part.

A fit that is farther off than the noise is systematically off, and the robust criterion takes points for
stray where it is.
"""

Make = Callable[[Any, float, Generator], Any]


def _fixed(value: float, off: float, rng: Generator) -> Any:
    return {"value": value * (1.0 + _sign(rng) * off)}


def _least(value: float, off: float, rng: Generator) -> Any:
    return {"min": value * (1.0 + _sign(rng) * off)}


def _most(value: float, off: float, rng: Generator) -> Any:
    return {"max": value * (1.0 + _sign(rng) * off)}


def _between(value: float, off: float, rng: Generator) -> Any:
    low, high = np.sort(value * (1.0 + off * rng.choice((-2.0, -1.0, 1.0, 2.0), 2, replace=False)))
    return {"min": float(low), "max": float(high)}


def _parallel(value: Any, off: float, rng: Generator) -> Any:
    return {"direction": _tilted(value, off, rng), "max_angle": 0.0}


def _within(value: Any, off: float, rng: Generator) -> Any:
    """Reached in two cases of three."""
    return {"direction": _tilted(value, off, rng), "max_angle": off * float(rng.choice((0.01, 0.5, 1.5)))}


def _tilted(value: Any, off: float, rng: Generator) -> list[float]:
    across = np.cross(value, rng.normal(size=3))
    tilted = np.array(value) + np.tan(off) * across / np.linalg.norm(across)
    return (_sign(rng) * tilted).tolist()


def _sign(rng: Generator) -> float:
    return float(rng.choice((-1.0, 1.0)))


POSITION = "at"
NUMBERS: dict[str, Make] = {"fixed": _fixed, "min": _least, "max": _most, "between": _between}
DIRECTIONS: dict[str, Make] = {"parallel": _parallel, "within": _within}
HOW = NUMBERS | DIRECTIONS
SIZES = {
    "sphere": ("radius",),
    "cylinder": ("radius",),
    "cone": ("half_angle",),
    "torus": ("major_radius", "minor_radius"),
}


def _single() -> list[tuple[str, dict[str, str]]]:
    found: list[tuple[str, dict[str, str]]] = []
    for kind, anchor in oracles.ANCHOR.items():
        found += [(kind, {name: how}) for name in SIZES.get(kind, ()) for how in NUMBERS]
        if kind in oracles.DIRECTION:
            found += [(kind, {oracles.DIRECTION[kind]: how}) for how in DIRECTIONS]
        found.append((kind, {anchor: POSITION}))
    return found


CONSTRAINED: tuple[tuple[str, dict[str, str]], ...] = (
    *_single(),
    ("plane", {"normal": "within", "point": POSITION}),
    ("sphere", {"radius": "between", "center": POSITION}),
    ("cylinder", {"axis": "within", "radius": "fixed", "point": POSITION}),
    ("cylinder", {"axis": "parallel", "radius": "min"}),
    ("cone", {"apex": POSITION, "half_angle": "fixed"}),
    ("cone", {"apex": POSITION, "axis": "within"}),
    ("cone", {"axis": "parallel", "half_angle": "max"}),
    ("torus", {"major_radius": "max", "minor_radius": "min"}),
    ("torus", {"center": POSITION, "axis": "within"}),
    ("torus", {"axis": "parallel", "major_radius": "fixed", "minor_radius": "between"}),
)
"""Each constraint of each kind, and combinations."""


def draw(seed: int, index: int) -> Trial:
    """Constraints take turns, then criteria."""
    kind, hows = CONSTRAINED[index % len(CONSTRAINED)]
    criterion = CRITERIA[index // len(CONSTRAINED) % len(CRITERIA)]
    rng = np.random.default_rng([seed, index, 13])
    made = part(kind, rng, more=MORE, arcs=ARCS, noise=NOISE)
    constraints = drawn(made, hows, OFF[criterion], rng)
    groups = {
        "kind": kind,
        "criterion": criterion,
        "constraints": ", ".join(f"{name} {how}" for name, how in hows.items()),
    }
    measure = beside_optimum if criterion == "least_squares" else beside_clean
    return Trial(groups, f"{made.about}; {constraints}", partial(measure, kind, made, constraints, rng))


def drawn(made: Part, hows: dict[str, str], reach: tuple[float, float], rng: Generator) -> Constraints:
    """Constraints that are off the nominal surface by so many standard deviations of the noise."""
    constraints = {}
    for name, how in hows.items():
        value, off = getattr(made.nominal, name), rng.uniform(*reach) * made.sigma / made.size
        if how == POSITION:
            constraints[name] = (value + off * made.size * rng.normal(size=3)).tolist()
        else:
            constraints[name] = HOW[how](value, off, rng)
    return constraints


def beside_optimum(kind: str, made: Part, constraints: Constraints, rng: Generator) -> Figures:
    """`excess`: of the sum of squares over the constrained optimum; `violation`: the largest."""
    found = fitted(kind, made.points, "least_squares", constraints)
    center = made.points.mean(axis=0)
    best = optimum(kind, *_from(center, kind, made, constraints), made.points - center)
    ours = oracles.cost(kind, found, made.points) / 2.0
    return {
        "violation": max(violations(found, constraints).values()),
        "excess": max(ours - best, 0.0) / best,
    }


def beside_clean(kind: str, made: Part, constraints: Constraints, rng: Generator) -> Figures:
    """`over clean`: the root mean square distance of the points that are not stray, over that of the optimum
    for them alone; `violation`: the largest."""
    points = made.points.copy()
    points[::STRAY] += made.size * rng.uniform(-0.3, 0.3, points[::STRAY].shape)
    found = fitted(kind, points, "robust", constraints, refused=True)
    kept = np.delete(made.points, slice(None, None, STRAY), axis=0)
    center = kept.mean(axis=0)
    best = optimum(kind, *_from(center, kind, made, constraints), kept - center)
    ours = oracles.cost(kind, found, kept) / 2.0
    return {
        "violation": max(violations(found, constraints).values()),
        "over clean": float(np.sqrt(ours / best)),
    }


def _from(
    center: oracles.Array, kind: str, made: Part, constraints: Constraints
) -> tuple[Constraints, oracles.Surface]:
    """The constraints and the nominal surface as seen from a centre."""
    nominal = oracles.framed(kind, oracles.long(parameters(made.nominal)), center, 1.0)
    return shifted(constraints, -center), nominal
