"""How many points the extreme criteria are done with in the time that a fit may take, whatever the cloud."""

from collections.abc import Mapping

from primfit.fitting.names import CRITERIA

POINTS_A_SECOND: Mapping[str, int] = {
    "minimum_zone": 50_000,
    "minimum_circumscribed": 50_000,
    "maximum_inscribed": 25_000,
}
"""Half the pace in the worst of the clouds tried, with all kinds allowed: steps differ from cloud to cloud.

Of a million points a cube took 10 s by its minimum zone, and a torus 19 s by its maximum inscribed cylinder
(`python -m tests.fire.extremes`). The other criteria have no limit of their own: nearly all clouds of
`max_points` are done in time."""


def points_by_criterion(seconds: float, most: int) -> dict[str, int]:
    """The most points of a cloud by criterion: what is done in so many seconds, and at most so many."""
    bound = {each: max(1, int(seconds * pace)) for each, pace in POINTS_A_SECOND.items()}
    return {each: min(most, bound.get(each, most)) for each in CRITERIA}
