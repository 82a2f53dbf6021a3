"""Minimum zone, minimum circumscribed and maximum inscribed surfaces beside other optimizers."""

from functools import partial

import numpy as np
from numpy.random import Generator
from scipy.spatial.transform import Rotation

from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.sphere import Sphere
from primfit.synthetic.recipes import KINDS

from . import oracles
from .fits import fitted
from .parts import Part, part
from .trial import Figures, Trial
from .zone_oracles import extreme, flatness, polished, smallest_sphere

ROUND = ("sphere", "cylinder")
PAIRS = (
    *((kind, "minimum_zone") for kind in KINDS),
    *((kind, "minimum_circumscribed") for kind in ROUND),
    *((kind, "maximum_inscribed") for kind in ROUND),
)
MORE = (1, 3, 6, 12, 25, 60)
NOISE = (-4.0, -2.0)
"""Powers of ten: under less, the zone is too close to the rounding of coordinates of a meter."""
ARCS = (90.0, 180.0, 360.0)
FEW = 16
"""Of so many points all sets that could determine the optimum are tried, where a kind has few enough."""
STARTS, FARTHEST = 3, 0.05
"""Of the other optimizer about the nominal surface, beside the answer itself."""


def draw(seed: int, index: int) -> Trial:
    """Kinds and criteria take turns. Inscribed surfaces, and every other circumscribed one, are of points
    all around."""
    kind, criterion = PAIRS[index % len(PAIRS)]
    rng = np.random.default_rng([seed, index, 12])
    around = criterion == "maximum_inscribed" or (
        criterion == "minimum_circumscribed" and index // len(PAIRS) % 2 == 0
    )
    made = _all_around(kind, rng) if around else part(kind, rng, more=MORE, arcs=ARCS, noise=NOISE)
    groups = {"kind": kind, "criterion": criterion}
    return Trial(groups, made.about, partial(beside_optimizer, kind, criterion, made, rng))


def all_around(kind: str, n: int, sigma: float, rng: Generator) -> oracles.Array:
    """Noisy points all around a sphere of radius 1, or a cylinder as long as wide, about the origin."""
    if kind == "sphere":
        points = rng.normal(size=(n, 3))
        points /= np.linalg.norm(points, axis=1)[:, None]
    else:
        angle = rng.uniform(0.0, 2.0 * np.pi, n)
        points = np.stack([np.cos(angle), np.sin(angle), rng.uniform(-1.0, 1.0, n)], axis=1)
    return np.asarray(points + rng.normal(0.0, sigma, (n, 3)))


def _all_around(kind: str, rng: Generator) -> Part:
    n, sigma = int(rng.choice((20, 40, 80))), 10.0 ** rng.uniform(*NOISE)
    radius, center = 0.5 * 10.0 ** rng.uniform(0.0, 2.7), rng.uniform(-700.0, 700.0, 3)
    turn = Rotation.random(random_state=rng).as_matrix()
    points = radius * all_around(kind, n, sigma, rng) @ turn.T + center
    nominal = Sphere(center, radius) if kind == "sphere" else Cylinder(turn[:, 2], center, radius)
    about = f"{n} points all around, noise {sigma * radius:.1e} mm, {nominal}"
    return Part(nominal, points, 2.0 * radius, sigma * radius, 360.0, about)


def beside_optimizer(kind: str, criterion: str, made: Part, rng: Generator) -> Figures:
    """`excess`: how much worse than the best of the others primfit's optimum is, relatively.

    `beyond`: how far the farthest point is on the wrong side of a circumscribed or inscribed surface, over
    the largest coordinate.
    """
    center, size = oracles.frame(made.points)
    points = (made.points - center) / size
    found = oracles.framed(kind, fitted(kind, made.points, criterion), center, size)
    nominal = oracles.framed(kind, oracles.long(parameters(made.nominal)), center, size)
    starts = [found, *oracles.near(kind, nominal, STARTS, rng, FARTHEST)]
    best = polished(kind, starts, points, criterion)
    if len(points) <= FEW and (kind, criterion) == ("plane", "minimum_zone"):
        best = min(best, flatness(points) / 2.0)
    if len(points) <= FEW and (kind, criterion) == ("sphere", "minimum_circumscribed"):
        best = min(best, smallest_sphere(points))
    if criterion == "minimum_zone":
        return {"excess": max(extreme(kind, found, points, criterion) - best, 0.0) / best}
    radius = float(found["radius"])
    wrong = extreme(kind, found, points, criterion) - radius
    sign = 1.0 if criterion == "minimum_circumscribed" else -1.0
    largest = float(np.abs(made.points).max()) / size
    return {
        "excess": max(sign * (radius - best), 0.0) / best,
        "beyond": max(sign * wrong, 0.0) / largest,
    }
