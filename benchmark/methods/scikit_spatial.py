"""scikit-spatial: least squares of planes, spheres (algebraic) and cylinders."""

from typing import Any

from skspatial import objects

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere

from . import Answer
from .subset import MOST_POINTS, at_most


class ScikitSpatial:
    """`best_fit` of each shape."""

    name = "scikit-spatial"
    package = "scikit-spatial"
    decides_kind = False
    kinds = ("plane", "sphere", "cylinder")
    settings = (
        "best_fit of each shape, which has no settings; cylinders get "
        f"{MOST_POINTS} random points of larger clouds, because it loops over points in Python"
    )

    def fit(self, points: Array, kind: str | None) -> Answer:
        try:
            found = best_fit(points, kind)
        except ValueError as failure:  # points that it calls too few or degenerate
            return Answer("no_fit", None, str(failure))
        return Answer("fitted", converted(found))


def best_fit(points: Array, kind: str | None) -> Any:
    match kind:
        case "plane":
            return objects.Plane.best_fit(points, full_matrices=False)  # else the SVD takes N^2 numbers
        case "sphere":
            return objects.Sphere.best_fit(points)
        case "cylinder":
            return objects.Cylinder.best_fit(at_most(MOST_POINTS, points))
    raise KeyError(kind)


def converted(found: Any) -> Primitive:
    match found:
        case objects.Plane():
            return Plane(found.normal, found.point)
        case objects.Sphere():
            return Sphere(found.point, found.radius)
    return Cylinder(found.vector, found.point, found.radius)
