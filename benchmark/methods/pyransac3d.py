"""pyRANSAC-3D: plain RANSAC for planes, spheres and cylinders."""

import math
import random
from typing import Any

import numpy as np
import pyransac3d

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere

from ..measures import diagonal
from . import Answer
from .subset import MOST_POINTS, at_most

THRESHOLD = 0.002
"""Largest distance of an inlier, as a share of the cloud's diagonal."""

ITERATIONS = 1000
CONFIDENCE = 0.9999


class Pyransac3d:
    """Its shapes, with the usual rule for when to stop where that rule holds."""

    name = "pyransac3d"
    package = "pyransac3d"
    decides_kind = False
    kinds = ("plane", "sphere", "cylinder")
    settings = (
        f"RANSAC with inliers within {THRESHOLD:.1%} of the bounding box's diagonal and at most {ITERATIONS} "
        f"iterations, a fixed seed; planes and spheres stop at a confidence of {CONFIDENCE}; cylinders, "
        f"which need three points of one cross-section, do not, and get {MOST_POINTS} random points of "
        "larger clouds, because it loops over points in Python"
    )

    def fit(self, points: Array, kind: str | None) -> Answer:
        random.seed(0)
        if kind == "cylinder":
            points = at_most(MOST_POINTS, points)
        try:
            found = ransac(points, kind)
        except ValueError as failure:  # too few points
            return Answer("no_fit", None, str(failure))
        if len(found.inliers) == 0:
            return Answer("no_fit", None, "no inliers")
        return Answer("fitted", converted(found))


def ransac(points: Array, kind: str | None) -> Any:
    threshold = THRESHOLD * diagonal(points)
    with np.errstate(divide="ignore", invalid="ignore"):  # of samples that define no shape
        match kind:
            case "plane":
                return pyransac3d.Plane().fit(points, threshold, ITERATIONS, Stop(3, len(points)))
            case "sphere":
                return pyransac3d.Sphere().fit(points, threshold, ITERATIONS, Stop(4, len(points)))
            case "cylinder":
                return pyransac3d.Cylinder().fit(points, threshold, ITERATIONS)
    raise KeyError(kind)


class Stop:
    """Called after each iteration: whether a sample without outliers has been drawn with `CONFIDENCE`.

    Source: Fischler and Bolles, "Random sample consensus", Communications of the ACM 24(6), 1981.
    """

    def __init__(self, sample: int, total: int) -> None:
        self.sample, self.total = sample, total

    def __call__(self, state: Any) -> bool:
        clean = (len(state["best_inliers"]) / self.total) ** self.sample
        missed = (state["iteration"] + 1) * math.log1p(-min(clean, 1.0 - 1e-16))
        return missed <= math.log(1.0 - CONFIDENCE)


def converted(found: Any) -> Primitive:
    match found:
        case pyransac3d.PlaneResult():
            normal, offset = np.array(found.equation[:3]), found.equation[3]
            return Plane(normal, -offset * normal)
        case pyransac3d.SphereResult():
            return Sphere(found.center, found.radius)
    return Cylinder(found.axis, found.center, found.radius)
