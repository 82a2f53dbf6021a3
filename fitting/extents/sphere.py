"""The part of a sphere that holds points: the smallest cap about them, a zone, or all of it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from ..geometry.vectors import Z_AXIS, Array, vector
from ..primitives.sphere import Sphere
from ..words import between
from . import _extents
from .values import Extents, Length, Place, Row, long

DIRECTIONS = 256
"""Directions that are asked where the sphere is empty."""


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
    axis : (3,) unit vector from the center to the middle of the cap; z of a full sphere
    half_angle : between the axis and the rim, as seen from the center, radians in (0, pi]; over pi / 2 the
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
    def of(cls, primitive: Sphere, points: Array, blur: float) -> Self:
        center, radius = primitive.center, primitive.radius
        pole, depth, low, full, coverage = _extents.sphere(points, center, radius, blur, SPREAD)
        axis = Z_AXIS if full else vector(pole)
        half_angle, start = _angle(depth), _angle(low)
        return cls(
            area=2.0 * math.pi * radius**2 * (depth - low),
            coverage=coverage,
            axis=axis,
            half_angle=half_angle,
            start_half_angle=start,
            full_sphere=full,
            height=radius * (depth - low),
            rim_center=center + radius * (1.0 - depth) * axis,
            rim_radius=0.0 if full else radius * math.sin(half_angle),
            start_rim_center=center + radius * (1.0 - low) * axis,
            start_rim_radius=radius * math.sin(start),
        )

    @property
    def arcs(self) -> dict[str, float]:
        return {"cap": 2.0 * math.degrees(self.half_angle)}

    @staticmethod
    def words(of: Mapping[str, Any], unit: str | None) -> list[Row]:
        if of["full_sphere"]:
            return [("part", "the full sphere")]
        end, height = math.degrees(of["half_angle"]), f"height {long(of['height'], unit)}"
        if of["start_half_angle"] > 0.0:
            ends = between(math.degrees(of["start_half_angle"]), end, "degrees")
            return [("part", f"a zone {ends} from its axis, {height}")]
        return [("part", f"a cap of half-angle {end:.5g} degrees, {height}")]


def _angle(height: float) -> float:
    """From the axis; of 1 - cos of it."""
    return 2.0 * math.asin(math.sqrt(height / 2.0))
