"""Where a criterion ends: the primitive, and what it minimizes."""

from dataclasses import dataclass, replace
from typing import Self

from ..geometry.vectors import Array
from ..noise.kernels import Kernel
from ..primitives.primitive import Primitive
from ..trial.limits import moved


@dataclass(frozen=True, eq=False)
class Finished:
    """A primitive that minimizes  sum rho(d / scale)  of its kernel.

    Attributes
    ----------
    kernel : None where it minimizes a largest value
    exact : it does so over the points that lie on it exactly, and no others
    """

    primitive: Primitive
    kernel: Kernel | None
    scale: float = 1.0
    exact: bool = False

    def moved(self, by: Array) -> Self:
        """The same shifted by (3,): from the frame of a pivot back to that of the cloud."""
        return replace(self, primitive=moved(self.primitive, by))
