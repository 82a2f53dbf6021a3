"""engeom: MAGSAC++ consensus for planes, spheres, cylinders and cones.

Source: Barath, Noskova, Ivashechkin and Matas, "MAGSAC++, a fast, reliable and accurate robust estimator",
CVPR 2020.
"""

import time
from typing import Any

import numpy as np
from engeom.geom3 import Cone3, Cylinder3, Plane3, Sphere3

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere

from ..measures import diagonal
from ..normals import estimate_normals
from . import Answer

SIGMA_MAX = 0.005
"""Upper bound of the noise, as a share of the cloud's diagonal."""

SEARCH = {"max_iterations": 1000, "confidence": 0.999, "seed": 0}


class Engeom:
    """`from_consensus` of each shape."""

    name = "engeom"
    package = "engeom"
    decides_kind = False
    kinds = ("plane", "sphere", "cylinder", "cone")
    settings = (
        f"MAGSAC++ consensus with sigma_max {SIGMA_MAX:.1%} of the bounding box's diagonal, at most "
        f"{SEARCH['max_iterations']} iterations, confidence {SEARCH['confidence']}, a fixed seed, and for "
        "cylinders and cones normals from local principal components (benchmark/normals.py)"
    )

    def fit(self, points: Array, kind: str | None) -> Answer:
        started = time.process_time()
        normals = estimate_normals(points) if kind in ("cylinder", "cone") else None
        spent = time.process_time() - started
        try:
            found = consensus(points, normals, kind)
        except ValueError as failure:  # no valid model, or too few points
            return Answer("no_fit", None, str(failure), normals_seconds=spent)
        return Answer("fitted", converted(found), normals_seconds=spent)


def consensus(points: Array, normals: Array | None, kind: str | None) -> Any:
    sigma_max = SIGMA_MAX * diagonal(points)
    match kind:
        case "plane":
            return Plane3.from_consensus(points, sigma_max, **SEARCH)
        case "sphere":
            return Sphere3.from_consensus(points, sigma_max, **SEARCH)
        case "cylinder":
            return Cylinder3.from_consensus(points, normals, sigma_max, **SEARCH)
        case "cone":
            return Cone3.from_consensus(points, normals, sigma_max, **SEARCH)
    raise KeyError(kind)


def converted(found: Any) -> Primitive:
    match found:
        case Plane3():
            normal = coordinates(found.normal)
            return Plane(normal, found.d * normal)
        case Sphere3():
            return Sphere(coordinates(found.center), found.r)
        case Cylinder3():
            return Cylinder(coordinates(found.direction), coordinates(found.center), found.r)
    return Cone(coordinates(found.tip), coordinates(found.direction), found.half_angle)


def coordinates(vector: Any) -> Array:
    return np.array([vector.x, vector.y, vector.z])
