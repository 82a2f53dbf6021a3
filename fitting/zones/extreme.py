"""Surfaces by their extreme points: minimum zone, minimum circumscribed, maximum inscribed.

`task` says which largest value each of them makes small, `exchange` over which points, `descent` how.
"""

from collections.abc import Sequence

import numpy as np

from ..cloud.cloud import Cloud
from ..errors import FailedFit
from ..primitives import direction_of
from ..primitives.primitive import Primitive
from ..solver.refine import stepped
from .descent import End
from .exchange import settle
from .task import MAXIMUM_INSCRIBED, MINIMUM_CIRCUMSCRIBED, MINIMUM_ZONE, Task

SAME_START = 1e-6
"""Starts that differ by less, in distances over the extent and in normals, lead to the same end."""

FEW = 200
"""At so many points starts are told apart."""


def minimum_zone(starts: Sequence[Primitive], cloud: Cloud) -> Primitive | FailedFit:
    """The surface whose largest distance is a local minimum, the best of those that the starts lead to."""
    return _best(MINIMUM_ZONE, starts, cloud).proven("minimum zone", cloud)


def minimum_circumscribed(starts: Sequence[Primitive], cloud: Cloud) -> Primitive | FailedFit:
    """The smallest sphere or cylinder near one of the starts that has all points inside.

    For a sphere there is one minimum; for a cylinder the axis is that of a minimum near a start. A start
    whose center or axis is far from the points is moved to their centroid.
    """
    near = [_moved_near(start, cloud) for start in starts]
    return _best(MINIMUM_CIRCUMSCRIBED, near, cloud).proven("minimum circumscribed surface", cloud)


def maximum_inscribed(starts: Sequence[Primitive], cloud: Cloud) -> Primitive | FailedFit:
    """The largest sphere or cylinder with all points outside and its center or axis between them.

    There may be several maxima: each start, and it shifted and tilted to either side by as much as its
    distances spread, lead to some of them, and the largest is taken.
    """
    around = [each for start in starts for each in _surroundings(start, cloud)]
    best = _best(MAXIMUM_INSCRIBED, around, cloud)
    if best.is_proven:
        return best.primitive
    kind = best.primitive.kind
    return FailedFit(
        f"the points do not enclose the {direction_of(kind) or 'center'} of a {kind}: "
        "an inscribed one grows without limit, or the search for it did not converge"
    )


def _best(task: Task, starts: Sequence[Primitive], cloud: Cloud) -> End:
    """Of the ends that are proven the one whose largest value is least; the first one where none is."""
    ends = [settle(task, start, cloud) for start in _different(starts, cloud)]
    proven = [end for end in ends if end.is_proven]
    return min(proven, key=lambda end: task.worst(end.primitive, cloud.points)) if proven else ends[0]


def _different(starts: Sequence[Primitive], cloud: Cloud) -> list[Primitive]:
    """The starts without those that are the same surface as one before, where the points are."""
    points = cloud.searched[:FEW]
    seen = np.empty((0, len(points), 4))
    kept = []
    for start in starts:
        looks = np.column_stack([start.signed_distance(points), start.gradient(points)])
        if not (np.abs(seen - looks).max(axis=(1, 2)) < SAME_START).any():
            kept.append(start)
            seen = np.concatenate([seen, looks[None]])
    return kept


def _moved_near(start: Primitive, cloud: Cloud) -> Primitive:
    row = start.row()
    if row[8] <= cloud.extent:
        return start
    row[3:6] = 0.0
    return type(start).from_row(row)


def _surroundings(start: Primitive, cloud: Cloud) -> list[Primitive]:
    spread = float(np.ptp(start.signed_distance(cloud.points)))
    steps = spread * np.vstack([np.zeros(start.dof - 1), np.eye(start.dof - 1), -np.eye(start.dof - 1)])
    return [stepped(start, MAXIMUM_INSCRIBED.padded(step)) for step in steps]
