"""The frames that the methods bring a cloud to before anything else."""

from collections.abc import Callable

import numpy as np

from primfit.fitting.cloud.cloud import check_points
from primfit.fitting.cloud.frame import Frame
from primfit.fitting.errors import InvalidPointCloudError
from primfit.fitting.geometry.vectors import Array, bounds
from primfit.fitting.primitives import values_of

from ..method import Found


def unit_cube(points: Array) -> Frame:
    """The frame in which the bounding box is centered and its longest side is 1."""
    lowest, highest = bounds(points)
    side = 2.0 * float(np.max(highest / 2.0 - lowest / 2.0))
    return Frame(lowest / 2.0 + highest / 2.0, side if 0.0 < side < np.inf else 1.0)


def answered(frame_of: Callable[[Array], Frame], fit: Callable[[Array], Found], points: Array) -> Found:
    """What `fit` finds in a frame of a cloud, in the units of the input.

    What is no cloud, and what came out as no finite surface, is a `Found` without a primitive that says so.
    """
    try:
        checked = check_points(points)
    except InvalidPointCloudError as error:
        return Found(None, str(error))
    frame = frame_of(checked)
    with np.errstate(all="ignore"):
        found = fit(frame.normalize(checked))
        if found.primitive is None:
            return found
        primitive = frame.restore(found.primitive)
        if not np.isfinite(values_of(primitive)).all():
            return Found(None, f"the {primitive.kind} is not finite", found.attempts, found.probabilities)
    return Found(primitive, found.note, found.attempts, found.probabilities)
