"""Surfaces seen by their curvatures, which a step changes linearly, to zero and beyond.

A sphere that flattens reaches the plane at no finite radius, but at curvature 0, and bends the other way from
there. So a surface is seen by what it is at the foot of the origin on it: its distance, its frame (normal n,
generator or meridian g, and e across both), and curvatures. A step of `fitting.solver.refine.stepped` is
translated to their first changes; the frame turns by the angle that this is, the others change by so much.
"""

import numpy as np

from .vectors import Array, basis, cross, foot_of_origin, rows

NEARER = 0.5
"""The origin must be nearer to the surface than this many radii."""

FLATTEST = 1e-100
"""Curvatures below this are taken for it: their inverse must be finite."""

LEAST_ANGLE = 1e-9
"""A cone keeps its half-angle [rad] so far from 0 and from 90 degrees."""


def turned(frame: Array, rotation: Array) -> Array:
    """The frame (3, 3) of row vectors turned by the components (3,) of a rotation vector along them.

    Rodrigues' formula: v + sin(t) / t (w x v) + (1 - cos t) / t^2 (w x (w x v)), t the length of w.
    """
    turn = rotation @ frame
    angle = float(np.linalg.norm(turn))
    half = 0.5 * angle
    first = np.sin(angle) / angle if angle > 0.0 else 1.0
    second = 0.5 * (np.sin(half) / half) ** 2 if half > 0.0 else 0.5
    x, y, z = turn
    across = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])  # v @ across is w x v
    moved = frame @ across
    return np.asarray(frame + first * moved + second * (moved @ across))


def inverse(curvature: float) -> float:
    return 1.0 / (curvature if abs(curvature) > FLATTEST else FLATTEST)


def bent_straight(row: Array, step: Array, is_cone: bool) -> Array | None:
    """The row (9,) of a cone after a step (dof,), or of a cylinder, which is one without an angle.

    Curvatures cos t / rho and sin t / rho of a cone, 1 / r of a cylinder, with rho from the axis to the foot.
    None where the origin is not near the surface.
    """
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
    outward, axis, across = turned(np.stack([outward, axis, across]), rotation + np.array([0.0, 0.0, turn]))
    normal, generator = cosine * outward - sine * axis, sine * outward + cosine * axis
    bend = (cosine - sine * turn - cosine * rho_by / rho) / rho
    taper = (sine + cosine * turn - sine * rho_by / rho) / rho
    distance += distance_by
    rho = inverse(float(np.hypot(bend, taper)))
    cosine, sine = bend * rho, taper * rho
    side = np.copysign(1.0, sine) * np.copysign(1.0, cosine)
    outward, axis = cosine * normal + sine * generator, side * (cosine * generator - sine * normal)
    foot = foot_of_origin(-distance * normal - rho * outward, axis)
    angle = float(np.arctan2(abs(sine), abs(cosine)))
    if is_cone:
        angle = min(max(angle, LEAST_ANGLE), np.pi / 2 - LEAST_ANGLE)
    offset = np.linalg.norm(foot) * np.cos(angle) - np.copysign(distance, distance * cosine)
    return rows(axis, foot, angle, offset=float(offset))
