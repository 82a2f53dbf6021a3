"""How many points the extreme criteria are done with in the time that a fit may take, whatever the cloud."""

from collections.abc import Mapping

from primfit.fitting.names import CRITERIA

POINTS_A_SECOND: Mapping[str, int] = {
    "minimum_zone": 50_000,
    "minimum_circumscribed": 50_000,
    "maximum_inscribed": 50_000,
}
"""The pace in the worst of the clouds that were tried on a busy machine, all kinds allowed.

They were spheres, tori, cubes and planes of 100,000 to 500,000 points, with noise and without, and took up to
1.0 s for each 100,000 points. This is given twice, as steps differ from cloud to cloud. The other criteria
have no limit of their own: nearly all clouds of `max_points` are done in time."""


def points_by_criterion(seconds: float, most: int) -> dict[str, int]:
    """The most points of a cloud by criterion: what is done in so many seconds, and at most so many."""
    bound = {each: max(1, int(seconds * pace)) for each, pace in POINTS_A_SECOND.items()}
    return {each: min(most, bound.get(each, most)) for each in CRITERIA}
