"""mesh2cad: the fits that it gives the regions of a mesh, given the points and normals of a cloud instead."""

from typing import Any

import numpy as np
from mesh2cad import fit as m2c

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere

from ..normals import estimate_normals
from . import Answer

NEIGHBOURS = 32
"""Neighbours that a normal is estimated from, but never more than `LARGEST_SHARE` of the cloud."""

LARGEST_SHARE = 1 / 8


class Mesh2cad:
    """Closed-form fits, each followed by the refinement that mesh2cad has for it."""

    name = "mesh2cad"
    package = "mesh2cad"
    decides_kind = False
    kinds = ("plane", "sphere", "cylinder", "cone")
    settings = (
        "fit_plane, or fit_sphere, fit_cylinder and fit_cone with their refinements; where fit_cone gives "
        "up, fit_cone_about_axis with the axis of the cylinder; in place of a mesh's normals those of "
        f"primfit's local principal components ({NEIGHBOURS} neighbours, at most 1/{1 / LARGEST_SHARE:.0f} "
        "of the cloud), turned away from the centroid; its tolerances are fixed"
    )

    def fit(self, points: Array, kind: str | None) -> Answer:
        found = fitted(points, kind)
        if found is None:
            return Answer("no_fit", None, f"fit_{kind} found none")
        return Answer("fitted", converted(found))


def fitted(points: Array, kind: str | None) -> Any:
    """What mesh2cad makes of it, or None."""
    if kind == "plane":
        return m2c.fit_plane(points)
    normals = outward_normals(points)
    match kind:
        case "sphere":
            sphere = m2c.fit_sphere(points, normals)
            return sphere and m2c.refine_sphere(sphere, points)
        case "cylinder":
            return cylinder(points, normals)
        case "cone":
            cone = m2c.fit_cone(points, normals) or cone_about_cylinder(points, normals)
            return cone and m2c.refine_cone(cone, points)
    raise KeyError(kind)


def cylinder(points: Array, normals: Array) -> Any:
    rough = m2c.fit_cylinder(points, normals)
    return rough and m2c.refine_cylinder(rough, points)


def cone_about_cylinder(points: Array, normals: Array) -> Any:
    around = cylinder(points, normals)
    return around and m2c.fit_cone_about_axis(around.point, around.axis, points, normals)


def outward_normals(points: Array) -> Array:
    """Unit normals (N, 3) that point away from the centroid: `fit_cone` needs them to agree in sign."""
    normals = estimate_normals(points, max(6, min(NEIGHBOURS, int(LARGEST_SHARE * len(points)))))
    inward = np.einsum("ij,ij->i", normals, points - points.mean(axis=0)) < 0.0
    normals[inward] *= -1.0
    return normals


def converted(found: Any) -> Primitive:
    match found.kind:
        case "plane":
            return Plane(found.normal, found.d * found.normal)
        case "sphere":
            return Sphere(found.center, found.radius)
        case "cylinder":
            return Cylinder(found.axis, found.point, found.radius)
    return Cone(found.apex, found.axis, found.half_angle)
