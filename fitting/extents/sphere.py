"""The part of a sphere that holds points: the smallest cap about them, a zone, or all of it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from ..geometry.vectors import TINY, Z_AXIS, Array, basis, unit
from ..primitives.sphere import Sphere
from .spread import CHANCE, USUAL, USUAL_GAPS, coverage, ends, turn
from .values import Extents, Length, Place

DIRECTIONS = 256
"""Directions that are asked where the sphere is empty ..."""

ASKED = 2000
"""... with so many of the points."""

NEAREST = 3
"""Fewer points than this in it do not fill a hole."""

OUTERMOST = 1000
"""So many points nearest to the rim of a cap move its axis ..."""

ALL_ROUND = 500
"""... with about so many of all, since those nearest may lie on one side."""

LARGEST_STEP, SMALLEST_STEP = 0.2, 0.001
"""Angles by which the axis of a cap is moved while that makes the cap smaller."""

WAYS = np.stack([np.cos(np.arange(12) * np.pi / 6.0), np.sin(np.arange(12) * np.pi / 6.0)], axis=1)
"""Directions of the moves that are tried, across the axis."""


def _spread() -> Array:
    """Directions (DIRECTIONS, 3) that are evenly spread, on a spiral."""
    k = np.arange(DIRECTIONS) + 0.5
    z, azimuth = 1.0 - 2.0 * k / DIRECTIONS, np.pi * (1.0 + np.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - z**2)
    return np.stack([ring * np.cos(azimuth), ring * np.sin(azimuth), z], axis=1)


SPREAD = _spread()


@dataclass(frozen=True, eq=False)
class SphereExtents(Extents):
    """The smallest cap about the points on a sphere; of a zone without a smaller one about its pole.

    Attributes
    ----------
    axis : (3,) unit vector from the centre to the middle of the cap; z of a full sphere
    half_angle : between the axis and the rim, as seen from the centre, radians in (0, pi]; over pi / 2 the
        cap is more than a hemisphere, and pi is the full sphere
    start_half_angle : of a zone, between the axis and its inner rim, the smaller opening, radians; 0 of a cap
    full_sphere : no part larger than chance explains is without points
    height : of the cap or zone along its axis
    rim_center, rim_radius : of the circle that ends it
    start_rim_center : (3,) of the circle where a zone begins; the pole of a cap
    start_rim_radius : of the circle where a zone begins; 0 of a cap
    """

    kind: ClassVar[str] = "sphere"

    axis: Array
    half_angle: float
    start_half_angle: float
    full_sphere: bool
    height: Length
    rim_center: Place
    rim_radius: Length
    start_rim_center: Place
    start_rim_radius: Length

    @classmethod
    def of(cls, primitive: Sphere, feet: Array, blur: float) -> Self:
        directions = (feet - primitive.center) / primitive.radius
        radius = primitive.radius
        axis, depth = _cap(directions, blur / radius)
        # Points left to chance leave a cap empty, of this share of the area at most.
        chance = (np.log(len(feet)) + CHANCE + 2.0) / len(feet)
        full = (2.0 - depth) / 2.0 <= min(chance, 0.25)
        if full:
            axis, depth = Z_AXIS, 2.0
        first, second = basis(axis)
        azimuth = np.arctan2(directions @ second, directions @ first)
        heights = _heights(directions, axis)
        low = 0.0 if full else _hole(heights, depth, azimuth, blur / radius)
        half_angle, start = _angle(depth), _angle(low)
        middle = np.sqrt(1.0 - (1.0 - (low + depth) / 2.0) ** 2)
        return cls(
            area=2.0 * np.pi * radius**2 * (depth - low),
            coverage=coverage(
                (heights - low) / (depth - low),
                azimuth / (2.0 * np.pi) + 0.5,
                (half_angle - start) / (2.0 * np.pi * max(middle, TINY)),
            ),
            axis=axis,
            half_angle=half_angle,
            start_half_angle=start,
            full_sphere=bool(full),
            height=radius * (depth - low),
            rim_center=primitive.center + radius * (1.0 - depth) * axis,
            rim_radius=0.0 if full else radius * float(np.sin(half_angle)),
            start_rim_center=primitive.center + radius * (1.0 - low) * axis,
            start_rim_radius=radius * float(np.sin(start)),
        )

    @property
    def arcs(self) -> dict[str, float]:
        return {"cap": 2.0 * math.degrees(self.half_angle)}

    @staticmethod
    def words(of: Mapping[str, Any]) -> list[str]:
        if of["full_sphere"]:
            return ["the full sphere"]
        end, height = math.degrees(of["half_angle"]), of["height"]
        if of["start_half_angle"] > 0.0:
            start = math.degrees(of["start_half_angle"])
            return [f"a zone from {start:.5g} to {end:.5g} degrees from its axis, height {height:.6g}"]
        return [f"a cap of half-angle {end:.5g} degrees, height {height:.6g}"]


def _angle(height: float) -> float:
    """From the axis; of 1 - cos of it."""
    return float(2.0 * np.arcsin(np.sqrt(height / 2.0)))


def _hole(heights: Array, depth: float, azimuth: Array, blur: float) -> float:
    """The height where a zone begins; 0 of a cap, whose middle holds points or which is not full around."""
    least = max(float(heights.min()), 0.0)
    if least * len(heights) <= CHANCE * depth:
        return 0.0
    low = float(np.clip(ends(heights, (blur * np.sqrt(least * (2.0 - least)), 0.0))[0], 0.0, depth))
    angles = np.sort(np.arccos(1.0 - np.clip(heights, 0.0, 2.0)))
    usual = (
        float(np.partition(np.diff(angles), -USUAL_GAPS)[-USUAL_GAPS]) if len(angles) > USUAL_GAPS else 0.0
    )
    if _angle(low) <= USUAL * usual or low >= depth or not turn(azimuth)[2]:
        return 0.0
    return low


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
        axis = _tightened(axis, np.concatenate([held[outermost], held[:: -(-len(held) // ALL_ROUND)]]))
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
    from scipy.spatial import cKDTree

    sample = directions[:: -(-len(directions) // ASKED)]
    tree = cKDTree(sample, balanced_tree=False, compact_nodes=False)
    apart = tree.query(-SPREAD, k=[min(NEAREST, len(sample))])[0][:, 0]
    return unit(SPREAD[np.argmax(apart)])


def _tightened(axis: Array, directions: Array) -> Array:
    """The axis of the smallest cap near that of a given one, moved while the cap becomes smaller."""
    across = np.ascontiguousarray(directions.T)
    step, lowest = LARGEST_STEP, float((axis @ across).min())
    while step > SMALLEST_STEP:
        tried = math.cos(step) * axis + math.sin(step) * (WAYS @ np.array(basis(axis)))
        reached = (tried @ across).min(axis=1)
        best = int(reached.argmax())
        if reached[best] > lowest:
            axis, lowest = tried[best], float(reached[best])
        else:
            step /= 2.0
    return unit(axis)
