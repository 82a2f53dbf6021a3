"""What M4's threshold is chosen by:  python -m primfit.paper.training.threshold [N]

Of the first N clouds (500) of the seed that networks are measured on, the share of which M4 finds the kind:
with one distance for all clouds, beyond which the next kind is tried and the first is answered if all are
farther, and with a multiple of the distance of the nearest kind.
"""

import sys

import torch

from primfit.synthetic import BenchmarkRecipe, cloud

from ..m4 import POINTS, ShapeNets, first_near, mean_distance
from ..parts.asking import probabilities, ranked, shown
from ..parts.normalization import unit_sphere
from .running import SEED

N = 500
DISTANCES = (0.005, 0.01, 0.015, 0.02, 0.025, 0.03, 0.05, 0.15)
"""Radii of the unit sphere."""
FACTORS = (1.01, 1.02, 1.03, 1.05, 1.1, 1.2)

Tried = tuple[str, list[str], list[float]]
"""The true kind of a cloud, all kinds, the most probable first, and how far the surface of each is."""


def tried(network: ShapeNets, index: int) -> Tried:
    """All kinds on a cloud."""
    made = cloud(BenchmarkRecipe(SEED + 1), index)
    points = unit_sphere(made.points).normalize(made.points)
    kinds = ranked(probabilities(network.kinds, shown(points, POINTS)))
    return made.kind, kinds, [mean_distance(network.fitted(kind, points)[0], points) for kind in kinds]


def below(distances: list[float], limit: float) -> int:
    """The first of the surfaces within a distance; the first of all where there is none."""
    return next((place for place, distance in enumerate(distances) if distance <= limit), 0)


def main(n: int) -> None:
    torch.set_num_threads(1)
    network = ShapeNets()
    found = [tried(network, index) for index in range(n)]
    for name, values, choose in (("distance", DISTANCES, below), ("times the nearest", FACTORS, first_near)):
        for value in values:
            right = [kinds[choose(distances, value)] == truth for truth, kinds, distances in found]
            print(f"{name} {value:g}: {sum(right) / n:.1%} of {n} clouds right")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else N)
