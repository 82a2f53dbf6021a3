"""Points of a surface on the plane of a map."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from primfit.fitting.geometry.vectors import Array


@dataclass(frozen=True, eq=False)
class Unrolled:
    """Points on the unrolled surface.

    Attributes
    ----------
    across, along : (N,) coordinates; lengths or degrees
    names : what they are
    lengths : which of them are
    """

    across: Array
    along: Array
    names: tuple[str, str]
    lengths: tuple[bool, bool]

    @property
    def is_upright(self) -> bool:
        """Whether both are lengths, and the range of `along` is the larger."""
        return all(self.lengths) and bool(np.ptp(self.along) > np.ptp(self.across))

    def turned(self) -> Self:
        """With the other coordinate across."""
        return replace(self, across=self.along, along=self.across, names=self.names[::-1])


def near(angle: Array, middle: float) -> Array:
    """Angles within half a turn of the middle."""
    return (angle - middle + np.pi) % (2.0 * np.pi) - np.pi + middle
