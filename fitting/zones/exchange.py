"""Few points decide: the least largest value over all points from that over some of them.

Let f be the largest value over all points, and f_S that over some points S. Then f_S <= f everywhere. Where a
surface is a local minimum of f_S, and no other point has a larger value there, f = f_S at that surface, and
f >= f_S >= f_S(surface) = f(surface) near it: it is a local minimum of f. So points that are not in S cannot
change it, whatever the kind and the criterion. Where others do have larger values, the largest of them join.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..cloud.cloud import Cloud
from ..geometry.vectors import Array
from ..primitives.primitive import Primitive
from .descent import End, descend
from .task import Task

FEW = 400
"""So many points, those of the largest values, decide first, and with them ..."""

SPREAD = 200
"""... so many random ones, which hold a surface where the points are if the former lie on one side."""

ROUNDS = 12
"""Times that points join, up to as many as are there, before the search is given up: by then they may be
a million. It takes two to five."""

SAME_WIDTH, ROUNDING = 1e-12, 1e-15
"""Values beyond the largest by less than this share of it, or by this in the frame, are not."""


def settle(task: Task, start: Primitive, cloud: Cloud) -> End:
    """Where the largest value over all points has a local minimum, if that is reached from the start.

    The way goes on from a minimum over some points with those that are beyond it, and anew from the start
    with those that are beyond where a search has failed. Where none is, it has failed for all points.
    """
    points = cloud.points
    if len(points) <= FEW + SPREAD:
        return descend(task, start, points, cloud)
    spread = cloud.working[cloud.sample[:SPREAD]]
    joined, place = _largest(task.values(start, points), len(task.signs), FEW), start
    for _ in range(ROUNDS):
        few = np.vstack([points[joined], spread])
        end = descend(task, place, few, cloud)
        values = task.values(end.primitive, points)
        level = task.worst(end.primitive, few)
        values[values <= level * (1.0 + np.copysign(SAME_WIDTH, level)) + ROUNDING] = -np.inf
        beyond = _largest(values, len(task.signs), max(FEW, len(joined)))
        if not len(beyond):
            return end
        joined, place = np.union1d(joined, beyond), end.primitive if end.is_proven else start
    return replace(end, is_proven=False)


def _largest(values: Array, signs: int, count: int) -> NDArray[np.intp]:
    """Indices (M,) of the points of the largest finite values, at most so many, as many of each sign."""
    of_sign = values.reshape(signs, -1)
    kept = min(count // signs, of_sign.shape[1])
    which = np.argpartition(-of_sign, kept - 1, axis=1)[:, :kept]
    return np.unique(which[np.isfinite(np.take_along_axis(of_sign, which, axis=1))])
