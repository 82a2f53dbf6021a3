"""The part of a sphere that holds points: the smallest cap about them, or all of it."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.spatial import cKDTree

from fitting.extents.spread import CHANCE, coverage, ends
from fitting.extents.values import Bounds, Length, Place
from fitting.geometry import TINY, Z_AXIS, Array, basis, unit
from fitting.primitives import Sphere

DIRECTIONS = 256
"""Directions that are asked where the sphere is empty ..."""

ASKED = 2000
"""... with so many of the points."""

NEAREST = 3
"""Fewer points than this in it do not fill a hole."""

OUTERMOST = 1000
"""So many points nearest to the rim of a cap move its axis."""

LARGEST_STEP, SMALLEST_STEP = 0.2, 0.001
"""Angles by which the axis of a cap is moved while that makes the cap smaller."""

WAYS = np.arange(12) * np.pi / 6.0
"""Azimuths of the moves that are tried."""


@dataclass(frozen=True, eq=False)
class SphereExtents(Bounds):
    """A spherical cap.

    Attributes
    ----------
    axis : (3,) unit vector from the centre to the middle of the cap; z of a full sphere
    half_angle : between the axis and the rim, as seen from the centre, in (0, pi]; over pi / 2 the cap is
        more than a hemisphere, and pi is the full sphere
    full_sphere : no part larger than chance explains is without points
    height : of the cap along its axis
    rim_center, rim_radius : of the circle that ends it
    """

    kind: ClassVar[str] = "sphere"

    axis: Array
    half_angle: float
    full_sphere: bool
    height: Length
    rim_center: Place
    rim_radius: Length

    @classmethod
    def of(cls, primitive: Sphere, feet: Array, blur: float) -> "SphereExtents":
        directions = (feet - primitive.center) / primitive.radius
        axis, depth = _cap(directions, blur / primitive.radius)
        # Points left to chance leave a cap empty, of this share of the area at most.
        chance = (np.log(len(feet)) + CHANCE + 2.0) / len(feet)
        full = (2.0 - depth) / 2.0 <= min(chance, 0.25)
        if full:
            axis, depth = Z_AXIS, 2.0
        first, second = basis(axis)
        share = np.arctan2(directions @ second, directions @ first) / (2.0 * np.pi) + 0.5
        half_angle = float(2.0 * np.arcsin(np.sqrt(depth / 2.0)))
        middle = np.sqrt(1.0 - (1.0 - depth / 2.0) ** 2)
        return cls(
            area=2.0 * np.pi * primitive.radius**2 * depth,
            coverage=coverage(
                _heights(directions, axis) / depth, share, half_angle / (2.0 * np.pi * max(middle, TINY))
            ),
            axis=axis,
            half_angle=half_angle,
            full_sphere=full,
            height=primitive.radius * depth,
            rim_center=primitive.center + primitive.radius * (1.0 - depth) * axis,
            rim_radius=0.0 if full else primitive.radius * float(np.sin(half_angle)),
        )


def _cap(directions: Array, blur: float) -> tuple[Array, float]:
    """Axis of the smallest cap about unit vectors (N, 3), and its height, 1 - cos of its half-angle."""
    axis = _start(directions)
    depth = 2.0
    for _ in range(2):
        heights = _heights(directions, axis)
        depth = _rim(heights, blur)
        held = directions[heights <= depth]
        if len(held) < 3:
            break
        outermost = np.argpartition(held @ axis, min(OUTERMOST, len(held) - 1))[:OUTERMOST]
        axis = _tightened(axis, held[outermost])
    return axis, _rim(_heights(directions, axis), blur)


def _heights(directions: Array, axis: Array) -> Array:
    """1 - cos of the angles to the axis; of small caps, too, whose cosines are all 1."""
    apart = directions - axis
    return np.einsum("ij,ij->i", apart, apart) / 2.0


def _rim(heights: Array, blur: float) -> float:
    """Where the heights of the points on a cap end; equal heights are equal areas."""
    highest = min(float(heights.max()), 2.0)
    slope = np.sqrt(max(highest * (2.0 - highest), 0.0))
    return float(np.clip(ends(heights, (0.0, blur * slope))[1], TINY, 2.0))


def _start(directions: Array) -> Array:
    """An axis away from where there are no points: their mean, or the best of many directions."""
    mean = directions.mean(axis=0)
    size = np.sqrt(mean @ mean)
    if size > 0.5:  # the mean of a hemisphere
        return unit(mean)
    k = np.arange(DIRECTIONS) + 0.5
    z, azimuth = 1.0 - 2.0 * k / DIRECTIONS, np.pi * (1.0 + np.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - z**2)
    asked = np.stack([ring * np.cos(azimuth), ring * np.sin(azimuth), z], axis=1)
    sample = directions[:: -(-len(directions) // ASKED)]
    apart = cKDTree(sample).query(-asked, k=[min(NEAREST, len(sample))])[0][:, 0]
    return unit(asked[np.argmax(apart)])


def _tightened(axis: Array, directions: Array) -> Array:
    """The axis of the smallest cap near that of a given one, moved while the cap becomes smaller."""
    step, lowest = LARGEST_STEP, float((directions @ axis).min())
    while step > SMALLEST_STEP:
        first, second = basis(axis)
        sideways = np.multiply.outer(np.cos(WAYS), first) + np.multiply.outer(np.sin(WAYS), second)
        tried = np.cos(step) * axis + np.sin(step) * sideways
        reached = (tried @ directions.T).min(axis=1)
        best = int(np.argmax(reached))
        if reached[best] > lowest:
            axis, lowest = tried[best], float(reached[best])
        else:
            step /= 2.0
    return unit(axis)
