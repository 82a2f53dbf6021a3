"""Plain least squares of signed orthogonal distances, as the paper's methods M2, M4, M5 and M6 end.

They name geomfitty, SciPy and the standards of ISO for it; all of these minimize the sum of squared
orthogonal distances by steps from a start. Here the steps are those of `primfit.fitting.solver`, with every
point in the sum and none of the robust kernels of primfit.
"""

import numpy as np

from primfit.fitting.cloud.frame import Frame
from primfit.fitting.cloud.normals import estimate_normals
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.guesses.oriented import Oriented
from primfit.fitting.primitives import PRIMITIVES, SIZES, values_of
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.solver.refine import distances, linearize, refine

STEPS = 200
"""After these a fit that still moves counts as one that diverges."""

GUESS_POINTS = 160
"""Starts are derived from so many points of the cloud, and ranked on them ..."""

STARTS = 3
"""... and so many of them are refined where none is given."""

LARGEST = 1e6
"""Lengths of a fit over the size of the cloud beyond which it has diverged."""

SMALLEST = 1e-9
"""Radius or angle [rad] below which it has shrunk to a line or a point."""

DETERMINED = 1e-10
"""Smallest singular value of the derivatives over the largest, below which points do not determine a kind."""


def least_squares(kind: str, points: Array, start: Primitive | None = None) -> Primitive | None:
    """The surface of that kind that minimizes the sum of squared orthogonal distances near a start.

    Parameters
    ----------
    points : (N, 3) finite, any unit
    start : of that kind, in the unit of the points; without one, the best of closed-form starts counts

    Returns
    -------
    None where it diverges, or where the points do not determine it.
    """
    if len(points) < PRIMITIVES[kind].dof:
        return None
    with np.errstate(all="ignore"):
        frame = Frame.of(points)
        normalized = frame.normalize(points)
        starts = own_starts(kind, normalized) if start is None else [frame.bring(start)]
        ends = [end for each in starts if (end := descended(each, normalized)) is not None]
        found = min(ends, key=lambda end: end[1], default=None)
        return None if found is None else frame.restore(found[0])


def descended(start: Primitive, points: Array) -> tuple[Primitive, float] | None:
    """Where the steps end, with half the sum of squares; None where they diverge."""
    if not np.isfinite(start.row()).all():
        return None
    try:
        end = refine(start, points, max_iterations=STEPS)
    except ValueError:  # an axis without a length
        return None
    return (end.primitive, end.cost) if end.converged and determined(end.primitive, points) else None


def determined(primitive: Primitive, points: Array) -> bool:
    """Whether points near the origin, with an extent near 1, leave a surface no freedom."""
    numbers = values_of(primitive)
    sizes = [getattr(primitive, name) for name in SIZES if hasattr(primitive, name)]
    if not np.isfinite(numbers).all() or np.abs(numbers).max() > LARGEST:
        return False
    if min(sizes, default=1.0) < SMALLEST:
        return False
    _, jacobian = linearize(primitive, points)
    singular = np.linalg.svd(jacobian / np.linalg.norm(jacobian, axis=0).clip(1e-300), compute_uv=False)
    return bool(singular[-1] > DETERMINED * singular[0])


def own_starts(kind: str, points: Array) -> list[Primitive]:
    """The closed-form starts with the least sum of squares on some of the points."""
    seen = points[np.linspace(0, len(points) - 1, min(GUESS_POINTS, len(points))).astype(int)]
    oriented = Oriented(seen, estimate_normals(points, at=seen))
    rows = PRIMITIVES[kind].initial_guesses(oriented, np.random.default_rng(0))
    starts = [PRIMITIVES[kind].from_row(row) for row in rows if np.isfinite(row).all()]
    costs = np.array([np.square(distances(start, seen)).sum() for start in starts])
    order = np.argsort(np.where(np.isfinite(costs), costs, np.inf), kind="stable")
    return [starts[k] for k in order[:STARTS]]
