"""Steps along which the curvatures of a surface change linearly, to zero and beyond.

A sphere that flattens reaches the plane at no finite radius, but at curvature 0, and bends the other way from
there. So a surface is seen by what it is at the foot of the origin on it: its distance, its frame (normal n,
generator or meridian g, and e across both), and curvatures. A step of `fitting.solver.refine.stepped` is
translated to their first changes; the frame turns by the angle that this is, the others change by so much.

========  ==============================================  =====================================
kind      curvatures                                      with
========  ==============================================  =====================================
sphere    1 / r
cylinder  1 / r
cone      cos t / rho, sin t / rho                        rho from the axis to the foot
torus     1 / r, cos v / rho, -sin v / rho                v the foot's azimuth around the tube
========  ==============================================  =====================================
"""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from ..geometry.vectors import Array, basis, cross, foot_of_origin, rows
from ..primitives import PRIMITIVES, Primitive
from ..solver.refine import stepped

NEARER = 0.5
"""The origin must be nearer to the surface than this many radii."""

FLATTEST = 1e-100
"""Curvatures below this are taken for it: their inverse must be finite."""

LEAST_ANGLE = 1e-9
"""A cone keeps its half-angle [rad] so far from 0 and from 90 degrees."""


def bent(primitive: Primitive, step: Array) -> Primitive:
    """The surface after a step (dof,), to first order that of `stepped`.

    `stepped` itself for a plane, and where the origin is not near the surface.
    """
    row = _BENT[primitive.kind](primitive.row(), step) if primitive.kind in _BENT else None
    return stepped(primitive, step) if row is None else PRIMITIVES[primitive.kind].from_row(row)


def _turned(frame: Array, rotation: Array) -> Array:
    """The frame (3, 3) of row vectors turned by the components (3,) of a rotation vector along them."""
    return np.asarray(Rotation.from_rotvec(rotation @ frame).apply(frame))


def _inverse(curvature: float) -> float:
    return 1.0 / (curvature if abs(curvature) > FLATTEST else FLATTEST)


def _bent_sphere(row: Array, step: Array) -> Array | None:
    center, radius = row[3:6], row[8]
    away = float(np.linalg.norm(center))
    distance = away - radius
    if abs(distance) > NEARER * radius or radius == 0.0:
        return None
    normal = -center / away
    frame = np.stack([normal, *basis(normal)])
    shift = frame @ step[:3]
    frame = _turned(frame, np.array([0.0, shift[2], -shift[1]]) / away)
    radius = _inverse((1.0 - step[3] / radius) / radius)
    distance -= shift[0] + step[3]
    return rows(row[:3], -(distance + radius) * frame[0], offset=abs(radius))


def _bent_cone(row: Array, step: Array, is_cone: bool = True) -> Array | None:
    """Cones, and cylinders as those without an angle."""
    axis, foot, angle, offset = row[:3], row[3:6], row[6], row[8]
    away = float(np.linalg.norm(foot))
    sine, cosine = np.sin(angle), np.cos(angle)
    distance = away * cosine - offset
    rho = away - distance * cosine
    if abs(distance) > NEARER * rho or away == 0.0:
        return None
    outward = -foot / away
    across = np.array(cross(axis, outward))
    tangents = np.stack(basis(axis))
    tilt, shift = step[:2] @ tangents, step[2:4] @ tangents
    turn, grown = (step[4], step[5]) if is_cone else (0.0, step[4])
    away_by = -shift @ outward
    distance_by = away_by * cosine - away * sine * turn - grown - away * (tilt @ outward) * sine
    rho_by = away_by - distance_by * cosine + distance * sine * turn
    rotation = np.array([-tilt @ across, -(shift @ across) / away, tilt @ outward])
    outward, axis, across = _turned(np.stack([outward, axis, across]), rotation + np.array([0.0, 0.0, turn]))
    normal, generator = cosine * outward - sine * axis, sine * outward + cosine * axis
    bend = (cosine - sine * turn - cosine * rho_by / rho) / rho
    taper = (sine + cosine * turn - sine * rho_by / rho) / rho
    distance += distance_by
    rho = _inverse(float(np.hypot(bend, taper)))
    cosine, sine = bend * rho, taper * rho
    side = np.copysign(1.0, sine) * np.copysign(1.0, cosine)
    outward, axis = cosine * normal + sine * generator, side * (cosine * generator - sine * normal)
    foot = foot_of_origin(-distance * normal - rho * outward, axis)
    angle = float(np.arctan2(abs(sine), abs(cosine)))
    if is_cone:
        angle = min(max(angle, LEAST_ANGLE), np.pi / 2 - LEAST_ANGLE)
    offset = np.linalg.norm(foot) * np.cos(angle) - np.copysign(distance, distance * cosine)
    return rows(axis, foot, angle, offset=float(offset))


def _bent_cylinder(row: Array, step: Array) -> Array | None:
    return _bent_cone(row, step, is_cone=False)


def _bent_torus(row: Array, step: Array) -> Array | None:
    axis, center, major, minor = row[:3], row[3:6], row[7], row[8]
    height = -float(center @ axis)
    outward = -center - height * axis
    away = float(np.linalg.norm(outward))
    tube = float(np.hypot(away - major, height))
    distance = tube - minor
    if abs(distance) > NEARER * min(minor, away) or away == 0.0 or minor == 0.0:
        return None
    outward = outward / away
    across = np.array(cross(axis, outward))
    tangents = np.stack(basis(axis))
    tilt, shift = step[:2] @ tangents, step[2:4] @ tangents
    cosine, sine = (away - major) / tube, height / tube
    height_by = away * (outward @ tilt) - step[4]
    away_by = -shift @ outward - height * (tilt @ outward)
    turn = (cosine * height_by - sine * (away_by - step[5])) / tube
    distance += cosine * (away_by - step[5]) + sine * height_by - step[6]
    rho = major + minor * cosine
    rho_by = step[5] + step[6] * cosine - minor * sine * turn
    rotation = np.array(
        [-tilt @ across, -(shift @ across + height * (tilt @ across)) / away, tilt @ outward - turn]
    )
    outward, axis, across = _turned(np.stack([outward, axis, across]), rotation)
    normal, meridian = cosine * outward + sine * axis, cosine * axis - sine * outward
    along_normal = (cosine - sine * turn - cosine * rho_by / rho) / rho
    along_meridian = -(sine + cosine * turn - sine * rho_by / rho) / rho
    rho = _inverse(float(np.hypot(along_normal, along_meridian)))
    cosine, sine = along_normal * rho, -along_meridian * rho
    outward, axis = cosine * normal - sine * meridian, sine * normal + cosine * meridian
    minor = _inverse((1.0 - step[6] / minor) / minor)
    center = -distance * normal - rho * outward - minor * sine * axis
    return rows(axis, center, major=abs(rho - minor * cosine), offset=abs(minor))


_BENT: dict[str, Callable[[Array, Array], Array | None]] = {
    "sphere": _bent_sphere,
    "cylinder": _bent_cylinder,
    "cone": _bent_cone,
    "torus": _bent_torus,
}
