"""What a search looks at: some of the cloud's points."""

from dataclasses import dataclass
from typing import Self

from ..geometry.vectors import Array
from ..trial.trial import Trial

SEARCH_POINTS = 512
"""Points that the annealing runs on."""


@dataclass(frozen=True, eq=False)
class View:
    """Points (N, 3) of a trial in random order, with normals (L, 3) at the first of them."""

    trial: Trial
    points: Array
    normals: Array

    @classmethod
    def of(cls, trial: Trial) -> Self:
        cloud = trial.cloud
        return cls(trial, cloud.working[cloud.sample[:SEARCH_POINTS]], cloud.normals)

    @classmethod
    def of_flattest(cls, trial: Trial) -> Self:
        """Of the part of a cloud that has the fewest outliers."""
        cloud = trial.cloud
        return cls(trial, cloud.working[cloud.sample[cloud.flattest]], cloud.normals[cloud.flattest])
