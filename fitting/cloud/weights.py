"""How much each point counts in the last refinement."""

import numpy as np

from ..errors import InvalidPointCloudError
from ..geometry.vectors import Array
from ..words import as_given

SMALLEST, LARGEST = 1e-100, 1e100
"""Beyond these magnitudes squares of weighted distances under- or overflow."""


def factors_of(weights: object, standard_deviations: object, n_points: int) -> Array | None:
    """What the distance of each point is multiplied by, (N,), or None where nothing is given.

    The roots of the weights, or one over the standard deviations, divided by the median of the positive ones:
    neither has a unit, and the scale of the residuals stays that of a typical point.

    Parameters
    ----------
    weights : (N,), not negative, or None; the cost of a point is multiplied by it, 0 leaves the point out
    standard_deviations : (N,) of the noise of each point, positive, or None
    """
    if weights is not None and standard_deviations is not None:
        raise InvalidPointCloudError("give weights or standard_deviations, not both", "weights")
    if standard_deviations is not None:
        sigma = _checked(standard_deviations, "standard_deviations", n_points)
        return np.asarray(np.median(sigma) / sigma)
    if weights is None:
        return None
    factors = np.sqrt(_checked(weights, "weights", n_points, zero_allowed=True))
    positive = factors[factors > 0.0]
    if len(positive) < 3:
        raise InvalidPointCloudError(
            f"{len(positive)} points have a weight over zero; at least 3 are needed", "weights"
        )
    return np.asarray(factors / np.median(positive))


def _checked(values: object, field: str, n_points: int, zero_allowed: bool = False) -> Array:
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidPointCloudError(f"{field} cannot be read as numbers of shape (N,)", field) from error
    if array.shape != (n_points,):
        raise InvalidPointCloudError(f"{field} have shape {array.shape}; ({n_points},) is needed", field)
    good = (array >= SMALLEST) & (array <= LARGEST)
    if zero_allowed:
        good |= array == 0.0
    if not good.all():
        first = int(np.argmin(good))
        raise InvalidPointCloudError(
            f"{field}[{first}] is {as_given(array[first])}; they lie between {SMALLEST:.0e} and {LARGEST:.0e}"
            + (" or are 0" if zero_allowed else ""),
            f"{field}[{first}]",
        )
    return array
