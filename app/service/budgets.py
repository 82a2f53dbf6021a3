"""How many points each criterion is done with in the time that a fit may take, whatever the cloud."""

from collections.abc import Mapping

from primfit.fitting.names import CRITERIA

POINTS_A_SECOND: Mapping[str, int] = {
    "robust": 100_000,
    "least_squares": 8_000,
    "huber": 5_000,
    "tukey": 5_000,
    "minimum_zone": 50_000,
    "minimum_circumscribed": 50_000,
    "maximum_inscribed": 50_000,
}
"""The pace in the worst of the clouds that were tried on a busy machine, with all kinds allowed.

They were spheres, tori, cubes and planes of 100,000 to 500,000 points, with noise and without. The worst were
planes with noise: each curved kind flattens, and takes all its steps over all points. For each 100,000 points
they took 0.5 s by the robust criterion, 12 s by least squares, 19 s by Huber's and Tukey's, and 1.0 s by the
extreme ones. These and the robust one are given twice that, as they end in steps that differ from cloud to
cloud by more."""


def points_by_criterion(seconds: float, most: int) -> dict[str, int]:
    """The most points of a cloud by criterion: what is done in so many seconds, and at most so many."""
    return {each: min(most, max(1, int(seconds * POINTS_A_SECOND[each]))) for each in CRITERIA}
