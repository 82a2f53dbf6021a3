"""Least squares beside the cheapest of many minima, and beside the nominal surface of exact points."""

from functools import partial

import numpy as np
from numpy.random import Generator

from primfit.fitting.primitives import parameters
from primfit.synthetic.recipes import KINDS

from . import oracles
from .fits import fitted
from .parts import Part, part
from .trial import Figures, Trial

ANGLE, LENGTH = 1e-7, 1e-4
"""What a reference value may be missed by, in radians and millimeters ..."""

RELATIVE = 1e-8
"""... and cost, angles, and lengths over the size of the cloud, where both are fitted to the same points."""

ULP = 4.0
"""Units in the last place of the largest coordinate by which rounding moves a point."""

STARTS, FARTHEST = 4, 0.3
"""Of the other optimizer, and how far from the nominal surface the last is, in root mean square radii."""


def draw(seed: int, index: int) -> Trial:
    """Kinds take turns; half of the parts are noisy, the others exact."""
    kind, exact = KINDS[index % len(KINDS)], index // len(KINDS) % 2 == 1
    rng = np.random.default_rng([seed, index, 11])
    made = part(kind, rng, exact)
    groups: dict[str, str | float] = {
        "kind": kind,
        "points": "minimal" if made.is_minimal else "more",
        "noise": "exact" if exact else "noisy",
        "arc": made.arc,
    }
    if kind == "cone":
        groups["half_angle"] = round(float(np.degrees(made.nominal.half_angle)), 3)  # type: ignore[attr-defined]
    held = partial(beside_nominal, kind, made) if exact else partial(beside_optimum, kind, made, rng)
    return Trial(groups, made.about, held)


def beside_optimum(kind: str, made: Part, rng: Generator, starts: int = STARTS) -> Figures:
    """How much more than the optimum primfit's sum of squares is, and how far from it the surface.

    `excess` is relative to the optimum, of which 1e-14 of the size squared a point are rounding. Angle and
    length are left out where the rounding of the coordinates hides more than 1e-8 of radian or size.
    """
    center, size = oracles.frame(made.points)
    points = (made.points - center) / size
    found = oracles.framed(kind, fitted(kind, made.points, "least_squares"), center, size)
    nominal = oracles.framed(kind, oracles.long(parameters(made.nominal)), center, size)
    ends = [*oracles.near(kind, nominal, starts, rng, FARTHEST), found]
    best = oracles.least_squares_optimum(kind, ends, points)
    ours, least = (oracles.cost(kind, surface, points) for surface in (found, best))
    figures = {"excess": max(ours - least, 0.0) / (least + 1e-14 * len(points))}
    if made.is_minimal:
        return figures  # several surfaces pass through them
    apart, hidden = _apart(kind, found, best, made)
    if hidden >= RELATIVE:
        del apart["angle"], apart["length"]
    return figures | apart


def beside_nominal(kind: str, made: Part) -> Figures:
    """How far from the nominal surface; of minimal sets only that it passes through the points."""
    found = fitted(kind, made.points, "least_squares")
    if made.is_minimal:
        distances = oracles.distances(kind, found, made.points.astype(np.longdouble))
        return {"off": float(np.abs(distances).max())}
    center, size = oracles.frame(made.points)
    nominal = oracles.long(parameters(made.nominal))
    one, other = (oracles.framed(kind, each, center, size) for each in (found, nominal))
    return _apart(kind, one, other, made)[0]


def _apart(
    kind: str, found: oracles.Surface, reference: oracles.Surface, made: Part
) -> tuple[Figures, float]:
    """`angle` [rad] and `length` [mm] between two surfaces, and what rounding hides, in radians and sizes.

    `missed` is the larger of the two over what may be missed: 1e-8, and what the rounding of the coordinates
    hides. There, lengths of large spheres and far apexes are in proportion to how far they are.
    """
    center, size = oracles.frame(made.points)
    points = (made.points - center) / size
    angle, length = oracles.misses(kind, found, reference, np.zeros(3))
    slopes = oracles.derivatives(kind, reference, points.astype(np.longdouble)).astype(np.float64)
    weakest = np.linalg.svd(slopes, compute_uv=False)[-1] / np.sqrt(len(points))
    hidden = float(ULP * np.spacing(np.abs(made.points).max()) / size / weakest)
    reach = max(1.0, float(np.linalg.norm(found[oracles.ANCHOR[kind]].astype(np.float64))))
    missed = max(angle, length / reach) / (RELATIVE + hidden)
    return {"angle": angle, "length": length * size, "missed": missed}, hidden
