"""CGAL: efficient RANSAC, which finds the kind itself.

Source: Schnabel, Wahl and Klein, "Efficient RANSAC for point-cloud shape detection", Computer Graphics Forum
26(2), 2007.
"""

import ctypes
import re
import time

import numpy as np
from CGAL import _CGAL_Shape_detection
from CGAL.CGAL_Kernel import Point_3
from CGAL.CGAL_Point_set_3 import Point_set_3
from CGAL.CGAL_Point_set_processing_3 import jet_estimate_normals
from CGAL.CGAL_Shape_detection import efficient_RANSAC

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.synthetic.recipes import KINDS

from ..measures import diagonal
from . import Answer

NEIGHBOURS = 32
EPSILON = 0.005
"""Largest distance of a point from its shape, as a share of the cloud's diagonal."""

CLUSTER_EPSILON = 0.1
"""Largest gap in a shape, as a share of the cloud's diagonal."""

LEAST_POINTS = 0.1
"""Share of the cloud that a shape takes at least."""

NORMAL_THRESHOLD = 0.9
PROBABILITY = 1e-4
"""Of overlooking the largest shape."""

NUMBER = re.compile(r"-?(?:\d+(?:\.\d*)?(?:e[-+]?\d+)?|\bnan\b|\binf\b)")

GENERATOR = "_ZZN4CGAL18get_default_randomEvE14default_random"
"""`CGAL::get_default_random()::default_random`; it holds the seed and, last, the state of a rand48."""


class Cgal:
    """All five kinds sought at once; the answer is the shape with most points."""

    name = "cgal"
    package = "cgal"
    decides_kind = True
    kinds = KINDS
    settings = (
        "efficient RANSAC for all five kinds at once, of whose shapes the one with most points is taken: "
        f"epsilon {EPSILON:.1%} and cluster epsilon {CLUSTER_EPSILON:.0%} of the bounding box's diagonal, at "
        f"least {LEAST_POINTS:.0%} of the points, normal threshold {NORMAL_THRESHOLD}, probability "
        f"{PROBABILITY:g}, normals by its jets over {NEIGHBOURS} neighbours, parameters to the 6 digits that "
        "its bindings print, a fixed seed"
    )

    def __init__(self) -> None:
        self.fit(np.random.default_rng(0).random((32, 3)), None)  # makes the generator that `seed` sets

    def fit(self, points: Array, kind: str | None) -> Answer:
        cloud = Point_set_3()
        cloud.add_normal_map()
        for x, y, z in points.tolist():
            cloud.insert(Point_3(x, y, z))
        started = time.process_time()
        jet_estimate_normals(cloud, min(NEIGHBOURS, len(points) - 1))
        spent = time.process_time() - started
        size = diagonal(points)
        seed()
        shapes = efficient_RANSAC(
            cloud,
            cloud.add_int_map("shape"),
            round(LEAST_POINTS * len(points)),
            EPSILON * size,
            CLUSTER_EPSILON * size,
            NORMAL_THRESHOLD,
            PROBABILITY,
            planes=True,
            cones=True,
            cylinders=True,
            spheres=True,
            tori=True,
        )
        if not shapes:
            return Answer("no_fit", None, "no shape found", normals_seconds=spent)
        largest, found = max(shapes, key=points_taken), f"shapes found: {len(shapes)}"
        return Answer("fitted", parsed(largest), found, normals_seconds=spent)


def seed() -> None:
    """Set CGAL's random numbers as a seed of 0 does, on Linux; the bindings have no function for it."""
    library = ctypes.CDLL(_CGAL_Shape_detection.__file__)
    (ctypes.c_uint64 * 3).in_dll(library, GENERATOR)[:] = [0, 0, 0x330E]


def points_taken(shape: str) -> int:
    return int(shape.rpartition("#Pts:")[2])


def parsed(shape: str) -> Primitive:
    """A shape from its printed form, such as `Type: sphere center: (0, 0, 1) radius:2 #Pts: 500`."""
    numbers = np.array(NUMBER.findall(shape.rpartition("#Pts:")[0]), dtype=np.float64)
    first, second, rest = numbers[:3], numbers[3:6], numbers[6:]
    match shape.split()[1]:
        case "plane":  # printed as n.x - d = 0, but n.x + d = 0 is meant
            return Plane(first, -numbers[3] * first)
        case "sphere":
            return Sphere(first, numbers[3])
        case "cylinder":
            return Cylinder(second, first, *rest)
        case "cone":
            return Cone(first, second, *rest)
        case "torus":
            return Torus(first, second, *rest)
    raise ValueError(f"a shape of no known kind: {shape}")
