"""trimesh: least squares of planes and spheres. Its cylinder is one that bounds the points, not a fit."""

from trimesh.nsphere import fit_nsphere
from trimesh.points import plane_fit

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere

from . import Answer


class Trimesh:
    """`points.plane_fit` and `nsphere.fit_nsphere`."""

    name = "trimesh"
    package = "trimesh"
    decides_kind = False
    kinds = ("plane", "sphere")
    settings = "points.plane_fit and nsphere.fit_nsphere, both least squares, neither with a setting"

    def fit(self, points: Array, kind: str | None) -> Answer:
        if kind == "plane":
            center, normal = plane_fit(points)
            return Answer("fitted", Plane(normal, center))
        try:
            center, radius, _ = fit_nsphere(points)
        except ValueError as failure:
            return Answer("no_fit", None, str(failure))
        return Answer("fitted", Sphere(center, radius))
