"""M5, "PointNet bundle": three PointNets vote on the kind, direct fits find the parameters.

The paper
    Clouds are brought to 8,100 points by copies moved a little along one coordinate, normalized, and turned
    about z at random while networks learn. PointNets with both alignment nets are trained with different
    parameters (Adam, rate 2.5e-4, 10 epochs), and the three best on the validation set vote. A plane, sphere
    or cylinder is fitted by least squares (geomfitty). Of a cone, tangent planes give the vertex; the circle
    of the points at one distance from it gives axis and angle. SciPy minimizes distances for the torus.
It leaves open
    Which parameters differ; what is answered where all three disagree; widths; the size of the shift.
Chosen
    512 points of a cloud, with a fifth of them moved; the three networks differ in their widths and seeds
    (`training.stages.BUNDLE`) and are the only ones trained. Where all disagree, the largest mean
    probability decides. Where tangent planes do not meet in a cone, least squares fits it. Tori, too, are
    fitted by `parts.least_squares`. The rate is that of `training.stages`: there are fewer steps than the
    paper had. Networks are measured on clouds of another seed instead of a share of the same.
"""

from collections import Counter
from pathlib import Path

import numpy as np

from primfit.fitting.cloud.normals import estimate_normals
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.primitive import Primitive

from .method import DIRECTORY, Found
from .parts.asking import Probabilities, probabilities, ranked, shown
from .parts.frames import answered
from .parts.least_squares import least_squares
from .parts.normalization import unit_sphere
from .parts.numbers import LEAST
from .parts.stored import restored

POINTS = 512
BUNDLE = 3
FEWEST = 6
"""Points that tangent planes are made of, at least."""


class PointNetBundle:
    """The kind by three networks, the parameters by least squares."""

    name = "m5"
    title = "M5: PointNet bundle and least squares"
    settings = f"networks of paper/weights/m5-*, which see {POINTS} points in the unit sphere"
    packages: tuple[str, ...] = ("torch",)

    def __init__(self, directory: Path = DIRECTORY) -> None:
        self.networks = [restored(f"m5-{number}", directory) for number in range(1, BUNDLE + 1)]

    def fit(self, points: Array) -> Found:
        """The kind that most networks name, fitted."""
        return answered(unit_sphere, self.fit_inside, points)

    def fit_inside(self, points: Array) -> Found:
        """The same in the unit sphere."""
        asked = shown(points, POINTS)
        votes = [probabilities(network, asked) for network in self.networks]
        chances = mean(votes)
        kind = elected([ranked(vote)[0] for vote in votes], chances)
        primitive = fitted(kind, points)
        note = "" if primitive else f"least squares finds no {kind}"
        return Found(primitive, note, (kind,), chances)


def mean(votes: list[Probabilities]) -> Probabilities:
    """Of the probabilities of several networks."""
    shares = np.mean([[share for _, share in vote] for vote in votes], axis=0)
    return tuple(zip((kind for kind, _ in votes[0]), shares.tolist(), strict=True))


def elected(named: list[str], chances: Probabilities) -> str:
    """The kind that most name; among equals the most probable one."""
    counts = Counter(named)
    return max(ranked(chances), key=lambda kind: counts[kind])


def fitted(kind: str, points: Array) -> Primitive | None:
    """By the direct fit of the kind, in the unit sphere."""
    cone = cone_by_tangents(points) if kind == "cone" else None
    return cone or least_squares(kind, points)


def cone_by_tangents(points: Array) -> Cone | None:
    """Its vertex from tangent planes, axis and angle from the circle that directions from there make.

    The vertex is where  n . (x - c) = 0  of all planes hold best; the unit vectors from it to the points lie
    in a plane across the axis, at the height cos(angle). None where the equations are singular, or the angle
    is none of a cone.
    """
    if len(points) < FEWEST:
        return None
    normals = estimate_normals(points, at=points)
    vertex, _, rank, _ = np.linalg.lstsq(normals, np.einsum("ij,ij->i", normals, points), rcond=1e-6)
    away = points - vertex
    lengths = np.linalg.norm(away, axis=1)
    if rank < 3 or not np.isfinite(vertex).all() or lengths.min() == 0.0:
        return None
    units = away / lengths[:, None]
    middle = units.mean(axis=0)
    axis = np.linalg.svd(units - middle, full_matrices=False)[2][2]
    height = float(middle @ axis)
    angle = float(np.arccos(np.clip(abs(height), 0.0, 1.0)))
    if not LEAST < angle < np.pi / 2 - LEAST:
        return None
    return Cone(vertex, axis if height > 0.0 else -axis, angle)
