"""What a search looks at: some of the cloud's points."""

from dataclasses import dataclass
from typing import Self

from ..cloud.cloud import GUESS_POINTS
from ..geometry.vectors import Array
from ..guesses.oriented import Oriented
from ..trial.trial import Trial


@dataclass(frozen=True, eq=False)
class View:
    """Points (N, 3) of a trial in random order, and the first of them, in the frame of the cloud."""

    trial: Trial
    points: Array
    oriented: Oriented

    @classmethod
    def of(cls, trial: Trial) -> Self:
        cloud, limits = trial.cloud, trial.limits
        if limits is None:
            return cls(trial, cloud.searched, cloud.oriented)
        return cls(
            trial, cloud.searched, Oriented(cloud.oriented.points + limits.pivot, cloud.oriented.normals)
        )

    @classmethod
    def of_flattest(cls, trial: Trial) -> Self:
        """Of the part of a cloud that has the fewest outliers."""
        cloud = trial.cloud
        flattest, pivot = cloud.flattest[:GUESS_POINTS], 0.0 if trial.limits is None else trial.limits.pivot
        points = cloud.working[cloud.sample[cloud.flattest]]
        return cls(trial, points, Oriented(points[:GUESS_POINTS] + pivot, cloud.normals[flattest]))
