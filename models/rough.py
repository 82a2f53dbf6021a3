"""All five kinds fitted roughly to one cloud: how well each does tells them apart.

The answer comes from another fit, in `fitting.search`. Here everything turns with the cloud, so an axis is
looked for only where the cloud has one: in its normals, its principal axes and the line that its normals meet
best.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.geometry.vectors import rows
from primfit.fitting.guesses.oriented import RevolutionAxis, revolution_axis
from primfit.fitting.primitives import PRIMITIVES
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.search.starts import compete

from . import _features

Array = NDArray[np.float64]

KINDS = ("plane", "sphere", "cylinder", "cone", "torus")
"""That the features tell apart, and classifiers have learned; another one makes other features."""

STARTING_POINTS = 96
"""Points that starts are solved for on ..."""
LINEAR_ROUNDS = 2
"""... in so many reweighted rounds."""
STAGES = np.array([[48, 4, 3], [64, 8, 1], [512, 3, 1]])
"""Points, robust steps, and how many of the best go on to the next stage."""
FLOOR = 1e-6
"""Smallest scale of the robust steps, in rms radii of the cloud; it is added to eigenvalues, too."""
RESOLVED = 1e-3
"""Distances, in rms radii of the cloud, below which one fit is not taken for better than another."""
SPREAD, LEAST_SCALE = 1.48, 1e-5
"""The scale of the residuals is the smallest median times the first, as of normal noise ..."""
OUTLYING = 9.0
"""... and squared residuals are counted up to this many squared scales."""

N_ROUGH = 4 + 2 * len(KINDS) + len(KINDS) * (len(KINDS) - 1) // 2 + 5
"""Three eigenvalues, the number of points, two distances a kind, each two kinds compared, five shapes."""
UPPER = np.triu_indices(len(KINDS), 1)


def evenly(count: int, points: Array, normals: Array) -> tuple[Array, Array]:
    """At most `count` of the points with their normals, evenly spread over their order."""
    if len(points) <= count:
        return points, normals
    chosen = np.linspace(0, len(points) - 1, count).astype(int)
    return points[chosen], normals[chosen]


def starts(points: Array, normals: Array, line: RevolutionAxis) -> dict[str, Array]:
    """Rows (K, 9) of each kind to step from."""
    scatter = np.stack([points.T @ points, normals.T @ normals])
    principal, by_normals = np.linalg.eigh(scatter)[1].transpose(0, 2, 1)
    directions = np.vstack([by_normals, line.direction, principal])
    return {
        "plane": rows(np.vstack([principal[0], by_normals[2]]), np.zeros((2, 3))),
        "sphere": Sphere.rows_through(points[None], LINEAR_ROUNDS),
        "cylinder": Cylinder.rows_about(directions, points, LINEAR_ROUNDS),
        "cone": Cone.rows_about(directions, points, LINEAR_ROUNDS),
        "torus": Torus.rows_about(directions, points, normals, line, LINEAR_ROUNDS),
    }


def rough_fits(points: Array, normals: Array, line: RevolutionAxis) -> tuple[Array, Array]:
    """A row (9,) of each kind, stacked, and the distances (5, N) of the points from each."""
    few, few_normals = evenly(STARTING_POINTS, points, normals)
    fits, distances = np.empty((len(KINDS), 9)), np.empty((len(KINDS), len(points)))
    rough = starts(few, few_normals, line)
    for k, kind in enumerate(KINDS):
        found = rough[kind]
        if kind == "torus":
            along = Torus.rows_along(fits[KINDS.index("cylinder")], few, few_normals, LINEAR_ROUNDS)
            found = np.vstack([found, along])
        fits[k], distances[k] = compete(kind, found, points, FLOOR, RESOLVED, STAGES)
    return fits, distances


@dataclass(frozen=True, eq=False)
class RoughFits:
    """A rough surface of each kind, as rows (5, 9) relative to a center, over the rms radius of a cloud."""

    rows: Array
    center: Array
    radius: float

    def of(self, kind: str) -> Primitive | None:
        """That of a kind, in the unit and the frame of the cloud; None if there is none."""
        row = self.rows[KINDS.index(kind)] if kind in KINDS else None
        if row is None or not np.isfinite(row).all() or self.radius == 0.0:
            return None
        return PRIMITIVES[kind].from_row(row).transformed(np.eye(3), self.center, self.radius)


def rough_features(points: Array, normals: Array) -> tuple[Array, Array]:
    """How far each kind is from the points, how the distances compare, and what shapes were found.

    Parameters
    ----------
    points : (N, 3), centered, with rms radius 1
    normals : (N, 3), signs arbitrary

    Returns
    -------
    (N_ROUGH,), and the rough surfaces (5, 9)
    """
    line = revolution_axis(points, normals, rounds=3)
    fits, distances = rough_fits(points, normals, line)
    median, mean, cost = _features.compared(distances, LEAST_SCALE, SPREAD, OUTLYING)
    _, sphere, cylinder, cone, torus = fits
    found = np.concatenate(
        [
            np.log10(np.maximum(line.eigenvalues, 0.0) + FLOOR),
            [np.log10(len(points))],
            np.log10(median + 1e-5),
            np.log10(mean + 1e-5),
            np.arcsinh(cost[UPPER[0]] - cost[UPPER[1]]),
            [
                np.log10(min(sphere[8], 1e6) + 1e-2),
                np.log10(min(cylinder[8], 1e6) + 1e-2),
                np.sin(cone[6]),
                np.log10(min(torus[8], 1e6) + 1e-2),
                np.tanh(torus[7] / (torus[8] + 1e-2)),
            ],
        ]
    )
    return found, fits
