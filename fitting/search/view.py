"""What a search looks at: some of the cloud's points."""

from dataclasses import dataclass
from typing import Self

from ..cloud.cloud import Cloud
from ..geometry.vectors import Array
from ..solver.limits import Limits

SEARCH_POINTS = 512
"""Points that the annealing runs on."""


@dataclass(frozen=True, eq=False)
class View:
    """What a search looks at: points (N, 3) in random order, normals (L, 3) at the first, the rounding.

    With limits, the points are relative to their pivot and the search stays within them.
    """

    points: Array
    normals: Array
    tolerance: float
    limits: Limits | None = None

    @classmethod
    def of(cls, cloud: Cloud, limits: Limits | None = None) -> Self:
        return cls(cloud.working[cloud.sample[:SEARCH_POINTS]], cloud.normals, cloud.tolerance, limits)

    @classmethod
    def of_flattest(cls, cloud: Cloud, limits: Limits | None = None) -> Self:
        """Of the part of a cloud that has the fewest outliers."""
        points = cloud.working[cloud.sample[cloud.flattest]]
        return cls(points, cloud.normals[cloud.flattest], cloud.tolerance, limits)
