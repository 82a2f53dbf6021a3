"""How many points each criterion is done with in the time that a fit may take, whatever the cloud."""

from collections.abc import Mapping

from primfit.fitting.names import CRITERIA, Criterion

POINTS_A_SECOND: Mapping[Criterion, int] = {
    "robust": 200_000,
    "least_squares": 20_000,
    "huber": 20_000,
    "tukey": 20_000,
    "minimum_zone": 200_000,
    "minimum_circumscribed": 200_000,
    "maximum_inscribed": 200_000,
}
"""PLACEHOLDER."""


def points_by_criterion(seconds: float, most: int) -> dict[Criterion, int]:
    """The most points of a cloud by criterion: what is done in so many seconds, and at most so many."""
    return {each: min(most, max(1, int(seconds * POINTS_A_SECOND[each]))) for each in CRITERIA}
