"""A kind that is tried on a cloud: what everything from the search to the uncertainty needs to know of it."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from ..cloud.cloud import Cloud
from ..geometry.vectors import Array
from ..primitives import PRIMITIVES
from ..primitives.primitive import Primitive
from ..request.constraints import Constraints
from ._limits import Bounds
from .limits import Limits

FEW = 5
"""Clouds of fewer than this many times the points that a kind takes are fitted without rejecting any."""

FEWEST_PARAMETERS = min(primitive.dof for primitive in PRIMITIVES.values())
"""Kinds most of whose parameters are fixed take as many points, where chance is reckoned with."""


@dataclass(frozen=True)
class Trial:
    """A kind, a cloud, and the limits that the caller's constraints set to it, or None."""

    kind: str
    cloud: Cloud
    limits: Limits | None = None

    @classmethod
    def of(cls, kind: str, cloud: Cloud, constraints: Constraints) -> Self:
        return cls(kind, cloud, Limits.of(constraints, kind, cloud.frame))

    @property
    def primitive(self) -> type[Primitive]:
        """The class of the kind."""
        return PRIMITIVES[self.kind]

    @cached_property
    def dof(self) -> int:
        """Points that determine it: as many as it has parameters that are not fixed.

        Bounded ones are free until the points have chosen a bound.
        """
        fixed = 0 if self.limits is None else int(np.count_nonzero(self.limits.frozen))
        return self.primitive.dof - fixed

    @property
    def is_small(self) -> bool:
        """Whether the cloud has too few points to reject any of them."""
        return len(self.cloud.working) < FEW * max(self.dof, FEWEST_PARAMETERS)

    @cached_property
    def bounds(self) -> Bounds | None:
        """The limits as the compiled steps obey them."""
        return None if self.limits is None else self.limits.bounds

    @property
    def free(self) -> Self:
        """The same without limits."""
        return replace(self, limits=None)

    @property
    def about_pivot(self) -> Self:
        """The same with the cloud relative to the pivot of its limits."""
        return self if self.limits is None else replace(self, cloud=self.cloud.about(self.limits.pivot))

    def held(self, row: Array) -> int:
        """How many parameters fixed values, and limits that are active, hold at a row (9,)."""
        return 0 if self.limits is None else self.limits.held(row)
