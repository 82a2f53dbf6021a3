"""Answers follow their cloud: turned, moved, scaled, permuted, or with every point twice.

Coordinates after a transformation are rounded anew, each by at most half a unit in the last place of the
largest, u. By linear propagation an error e of the distances moves the parameters of least squares by
dp = (J'J)^-1 J'e, with the Jacobian J of the distances at the N points, so J dp is the projection of e and
|J dp| <= |e| <= u sqrt(N). That is ulp times conditioning for all parameters and all their combinations c at
once: |c'dp| <= u sqrt(N) sqrt(c'(J'J)^-1 c) for every c, with equality for the worst, if and only if
|J dp| <= u sqrt(N). And J dp are the distances between the two surfaces at the points. So what is compared is
their root mean square over the points that belong to the answer, in units of u.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import count

import numpy as np
from numpy.random import Generator
from scipy.spatial.transform import Rotation

from primfit.fitting.answer.result import Recognition
from primfit.fitting.noise.rounding import rounding_of
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.recognize import recognize
from primfit.fitting.verdict.classifier import Classifier
from primfit.models import load_classifier
from primfit.synthetic import BenchmarkRecipe, cloud
from primfit.synthetic.recipes import KINDS, Range

from ..cases import CASE_SETS, REDRAWN, SCAN
from . import oracles
from .oracles import Array
from .trial import Figures, Trial

MOST_ULP = 64.0
"""What answers may differ by. More than 1: coordinates are rounded again in the frame of the fit, products of
a rotation three times, and the second derivatives of noisy distances are left out above."""

MOST_COMPARED = 2000
"""Points at which surfaces are compared; of more every k-th."""


@dataclass(frozen=True, eq=False)
class Moved:
    """x -> scale * rotation @ x + translation, and which points there are afterwards, in which order."""

    order: np.ndarray
    rotation: Array
    translation: Array
    scale: float = 1.0

    def apply(self, points: Array) -> Array:
        return np.asarray(self.scale * points[self.order] @ self.rotation.T + self.translation)

    def undo(self, primitive: Primitive) -> Primitive:
        back = self.rotation.T / self.scale @ self.translation
        return primitive.transformed(self.rotation.T, -back, 1.0 / self.scale)


Make = Callable[[Array, Generator], Moved]


def _turned(points: Array, rng: Generator) -> Moved:
    return replace(_still(points), rotation=Rotation.random(random_state=rng).as_matrix())


def _moved(extents: float) -> Make:
    def make(points: Array, rng: Generator) -> Moved:
        by = rng.normal(size=3)
        distance = extents * np.linalg.norm(np.ptp(points, axis=0)) / np.linalg.norm(by)
        return replace(_still(points), translation=distance * by)

    return make


def _scaled(power: int) -> Make:
    return lambda points, rng: replace(_still(points), scale=2.0**power)


def _permuted(points: Array, rng: Generator) -> Moved:
    return replace(_still(points), order=rng.permutation(len(points)))


def _doubled(points: Array, rng: Generator) -> Moved:
    return replace(_still(points), order=np.tile(np.arange(len(points)), 2))


def _still(points: Array) -> Moved:
    return Moved(np.arange(len(points)), np.eye(3), np.zeros(3))


TRANSFORMATIONS: dict[str, Make] = {
    "turned": _turned,
    "moved by 5 extents": _moved(5.0),
    "moved by 1,000 extents": _moved(1000.0),
    "4 times as large": _scaled(2),
    "2^20 times as large": _scaled(20),
    "2^-20 times as large": _scaled(-20),
    "permuted": _permuted,
    "every point twice": _doubled,
}


# -- clouds -------------------------------------------------------------------------------------------------


def _of_set(name: str, seed: int, index: int) -> Array:
    return CASE_SETS[name].draw(seed, index).points


def _exact(seed: int, index: int) -> Array:
    return cloud(BenchmarkRecipe(seed, (KINDS[index % len(KINDS)],), ("A0",)), index).points


def _large(seed: int, index: int) -> Array:
    """Twice as many points are more than 20,000, or they are so already."""
    points = LARGE[index // len(KINDS) % len(LARGE)]
    kinds = (KINDS[index % len(KINDS)],)
    return cloud(replace(SCAN, seed=seed, kinds=kinds, points=points), index).points


LARGE = (Range(11_000, 19_000), Range(21_000, 40_000))
CLOUDS: dict[str, Callable[[int, int], Array]] = {
    "scanner": partial(_of_set, "scanner"),
    "shrec": partial(_of_set, "shrec"),
    "scans-2": partial(_of_set, "scans-2"),
    "scans-0.3": partial(_of_set, "scans-0.3"),
    "exact": _exact,
    "large": _large,
}


def draw(seed: int, index: int) -> Trial:
    """Families take turns; clouds whose coordinates are written in decimal steps or as float32 are drawn
    again: they do not stay so."""
    family, number = tuple(CLOUDS)[index % len(CLOUDS)], index // len(CLOUDS)
    for other in count(number, REDRAWN):
        points = CLOUDS[family](seed, other)
        if not _is_coarse(points):
            break
    about = f"{family} {other}, {len(points)} points"
    return Trial(
        {"family": family}, about, partial(compare, points, np.random.default_rng([seed, index, 14]))
    )


def _is_coarse(points: Array) -> bool:
    as_float32 = np.array_equal(points.astype(np.float32), points)
    return as_float32 or rounding_of(points).step is not None


# -- answers ------------------------------------------------------------------------------------------------


def compare(points: Array, rng: Generator) -> Figures:
    """By transformation, how far the answer is from the one before, in units in the last place.

    Infinite where status or kind is another one.
    """
    before = _answer(points)
    figures = {}
    for name, make in TRANSFORMATIONS.items():
        by = make(points, rng)
        transformed = by.apply(points)
        after = _answer(transformed)
        largest = max(np.abs(points).max(), np.abs(transformed).max() / by.scale)
        same = (before.status, _kind(before)) == (after.status, _kind(after))
        figures[name] = _apart(points, before, after, by) / np.spacing(largest) if same else np.inf
    return figures


def _kind(answer: Recognition) -> str | None:
    return answer.primitive.kind if answer.primitive else None


def _apart(points: Array, before: Recognition, after: Recognition, by: Moved) -> float:
    """Root mean square distance of two surfaces of one kind at the points that belong to the first."""
    if before.primitive is None or before.inlier_rule is None or after.primitive is None:
        return 0.0
    kind = before.primitive.kind
    held = points[before.inlier_rule.among(points)]
    held = held[:: max(1, len(held) // MOST_COMPARED)]
    surfaces = (oracles.long(parameters(each)) for each in (before.primitive, by.undo(after.primitive)))
    one, other = (oracles.distances(kind, surface, held.astype(np.longdouble)) for surface in surfaces)
    if kind == "plane" and one @ other < 0.0:
        other = -other
    return float(np.sqrt(np.mean((one - other) ** 2)))


def _answer(points: Array) -> Recognition:
    return recognize(points, classifier=_classifier())


@cache
def _classifier() -> Classifier | None:
    return load_classifier("network")
