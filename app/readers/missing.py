"""Points that are missing: what a sensor writes where nothing came back."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from .cloud import Array, Cloud, check_finite, per_point, selected
from .errors import InvalidPointsError

DROPPED = NOT_FINITE, ZERO = "not_finite", "zero"
"""Why points are missing."""

_WORDS = {NOT_FINITE: "with coordinates that are not finite", ZERO: "exact zeros (0, 0, 0)"}


def without_missing(cloud: Cloud, missing: str = "drop") -> Cloud:
    """The cloud without the points that are missing; they are counted, and a warning says so.

    Those are points of which a coordinate is NaN or infinite, and exact zeros (0, 0, 0), if there are
    several: no surface is measured twice at the very origin, but depth cameras write it.

    Raises `InvalidPointsError` where all points are missing, or one is and `missing` is `error`, which leaves
    zeros alone.
    """
    if cloud.points.ndim != 2 or len({len(values) for values in per_point(cloud).values()}) > 1:
        return cloud  # which is refused for that
    if missing == "error":
        check_finite(cloud.points)
        return cloud
    lost = np.logical_not(np.isfinite(cloud.points).all(axis=1))
    zero = repeated_zeros(cloud.points)
    if zero is None and not lost.any():
        return cloud
    counts = {NOT_FINITE: int(np.count_nonzero(lost))}
    if zero is not None:
        counts[ZERO] = int(np.count_nonzero(zero))
        lost |= zero
    dropped = {name: cloud.dropped.get(name, 0) + counts.get(name, 0) for name in DROPPED}
    if lost.all():
        raise InvalidPointsError("points", f"no point is left: {_told(dropped)}")
    labels = None if cloud.labels is None else cloud.labels[~lost]
    return selected(
        cloud, np.flatnonzero(~lost), labels=labels, label_column=cloud.label_column, dropped=dropped
    )


def warnings_of(cloud: Cloud) -> tuple[str, ...]:
    """What the caller should know of the cloud: what its file told, and how many points are missing."""
    told = _told(cloud.dropped)
    return (*cloud.warnings, f"Missing points were dropped: {told}.") if told else cloud.warnings


def repeated_zeros(points: Array) -> NDArray[np.bool_] | None:
    """Which points (N, 3) are exact zeros, if several are."""
    if np.count_nonzero(points[:, 0] == 0.0) < 2:
        return None
    zero = (points == 0.0).all(axis=1)
    return zero if np.count_nonzero(zero) > 1 else None


def _told(dropped: Mapping[str, int]) -> str:
    return ", ".join(f"{dropped[name]} {words}" for name, words in _WORDS.items() if dropped.get(name))
