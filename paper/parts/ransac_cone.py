"""A cone by RANSAC on points with normals.

Three of them make one: the apex is where their tangent planes meet, the axis is across the plane through the
tips of the unit vectors from there to the points, the half-angle the mean one. Candidates are scored by the
points that lie within a distance and whose normals agree, and the best is refined by least squares on the
points within three such distances. Source: Schnabel, Wahl and Klein, "Efficient RANSAC for point-cloud shape
detection", Computer Graphics Forum 26(2), 2007, sections 4.1, 4.4 and 4.5.
"""

import numpy as np

from primfit.fitting.geometry.vectors import TINY, Array, cross
from primfit.fitting.guesses.oriented import Oriented, random_subsets
from primfit.fitting.primitives.cone import Cone

from .least_squares import least_squares

TRIPLES = 1000
NEAR = 0.01
"""Distance within which a point is on a candidate, in a frame in which the cloud's longest side is 1."""
ALIKE = np.cos(np.radians(20.0))
"""Least cosine between a point's normal and that of the candidate."""
REFIT = 3.0
"""Points within so many times `NEAR` are refined on."""
SLIGHTEST = np.radians(1.0)
"""Half-angles below this and, from a right angle, above are no cones."""


def ransac_cone(oriented: Oriented, points: Array, rng: np.random.Generator) -> Cone | None:
    """The cone of some points with normals, refined on all points (N, 3); None where no three make one."""
    apexes, axes, angles = candidates(oriented, rng)
    if not len(angles):
        return None
    best = int(np.argmax(scores(oriented, apexes, axes, angles)))
    cone = Cone(apexes[best], axes[best], angles[best])
    near = points[np.abs(cone.signed_distance(points)) <= REFIT * NEAR]
    refined = least_squares("cone", near, cone)
    return refined if isinstance(refined, Cone) else cone


def candidates(oriented: Oriented, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Apexes (K, 3), axes (K, 3) into the nappe and half-angles (K,) of cones through three points each."""
    if len(oriented.points) < 3:
        return np.empty((0, 3)), np.empty((0, 3)), np.empty(0)
    triples = random_subsets(len(oriented.points), 3, TRIPLES, rng)
    points, normals = oriented.points[triples], oriented.normals[triples]
    offsets = np.einsum("kij,kij->ki", normals, points)
    apexes = np.einsum("kij,kj->ki", np.linalg.pinv(normals), offsets)
    rays = points - apexes[:, None]
    rays /= np.linalg.norm(rays, axis=2, keepdims=True) + TINY
    axes = cross(rays[:, 1] - rays[:, 0], rays[:, 2] - rays[:, 0])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True) + TINY
    cosines = np.einsum("kij,kj->ki", rays, axes).mean(axis=1)
    angles = np.arccos(np.abs(cosines).clip(0.0, 1.0))
    usable = (angles > SLIGHTEST) & (angles < np.pi / 2 - SLIGHTEST) & np.isfinite(apexes).all(axis=1)
    axes *= np.where(cosines < 0.0, -1.0, 1.0)[:, None]
    return apexes[usable], axes[usable], angles[usable]


def scores(oriented: Oriented, apexes: Array, axes: Array, angles: Array) -> Array:
    """How many of the points (N, 3) lie on each of K cones, with a normal that agrees."""
    relative = oriented.points[None] - apexes[:, None]
    height = np.einsum("kni,ki->kn", relative, axes)
    rho = np.sqrt(np.maximum(np.einsum("kni,kni->kn", relative, relative) - height**2, 0.0))
    sine, cosine = np.sin(angles)[:, None], np.cos(angles)[:, None]
    lean = axes @ oriented.normals.T
    outwards = np.einsum("kni,ni->kn", relative, oriented.normals) - height * lean
    agree = np.abs(cosine * outwards / (rho + TINY) - sine * lean) >= ALIKE
    return (agree & (np.abs(rho * cosine - height * sine) <= NEAR) & (height > 0.0)).sum(axis=1)
