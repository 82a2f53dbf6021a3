"""What moves the points that a sensor sees off the surface: one small class an effect.

Each effect has a `size`, the root mean square of what it adds [m], moves the points that are there already
(`applied`), and knows the covariance of its part across the surface (`covariance`), so that whoever draws a
cloud can say what could still be told under all of them together (`synthetic.deciding`).
"""

from dataclasses import dataclass, fields
from typing import ClassVar, Protocol

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

from .fields import Field, Smooth
from .patches import Patch

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Seen:
    """Clean points on a canonical piece, and how they were seen; of N points from S stations.

    Attributes
    ----------
    points : (N, 3) on the surface [m]
    normals : (N, 3) unit
    rays : (N, 3) unit, from the station to the point
    distance : (N,) from the station [m]
    cosine : (N,) of the incidence
    depth : (N,) cosine between the ray and the optical axis
    image : (N, 2) place in the image, as tangents of angles from the middle of the piece
    line : (N,) scan line, ring or row of hits; of another station another one
    along : (N,) place on the line [m]
    station : (N,) which one saw it
    on_edge : (N,) whether it lies beside a ray that saw nothing of the piece
    weight : (N,) noise of the point over that of all, root mean square 1
    """

    points: Array
    normals: Array
    rays: Array
    distance: Array
    cosine: Array
    depth: Array
    image: Array
    line: Indices
    along: Array
    station: Indices
    on_edge: Mask
    weight: Array

    def part(self, chosen: Indices | Mask) -> "Seen":
        """Of these points only."""
        return Seen(*(getattr(self, field.name)[chosen] for field in fields(self)))

    @property
    def slope(self) -> Array:
        """How far a point leaves the surface for a step along its ray, signed (N,)."""
        return np.einsum("ij,ij->i", self.normals, self.rays)

    @property
    def extent(self) -> float:
        """The diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    @property
    def spacing(self) -> float:
        """About the distance of neighbours: the root of the area a point, of a flat square."""
        return self.extent / np.sqrt(2.0 * len(self.points))


class Effect(Protocol):
    """One cause of errors."""

    @property
    def name(self) -> str: ...

    @property
    def size(self) -> float:
        """Root mean square of what it adds [m]."""
        ...

    def applied(self, rng: Generator, seen: Seen, points: Array) -> Array:
        """The points (N, 3) moved."""
        ...

    def covariance(self, seen: Seen) -> Array:
        """Of its part along the normals, (N, N) [m^2]."""
        ...


def along_rays(seen: Seen, points: Array, error: Array) -> Array:
    return points + error[:, None] * seen.rays


def outer(vector: Array) -> Array:
    return np.multiply.outer(vector, vector)


def distances(points: Array) -> Array:
    return np.linalg.norm(points[:, None] - points[None], axis=2)


def standardised(shape: Array) -> Array:
    """Mean 0 and root mean square 1 over the points; zeros where the shape is constant."""
    centered = shape - shape.mean()
    rms = np.sqrt(np.mean(centered**2))
    return centered / rms if rms > 0.0 else centered


@dataclass(frozen=True)
class White:
    """Independent noise along the rays."""

    size: float
    name: ClassVar[str] = "white"

    def applied(self, rng: Generator, seen: Seen, points: Array) -> Array:
        return along_rays(seen, points, self.size * seen.weight * rng.standard_normal(len(points)))

    def covariance(self, seen: Seen) -> Array:
        return np.diag((self.size * seen.weight * seen.slope) ** 2)


@dataclass(frozen=True)
class Correlated:
    """A random field over the surface, along the rays."""

    size: float
    field: Field

    @property
    def name(self) -> str:
        """The sort of the field: rough, self-affine or smooth."""
        return self.field.name

    def applied(self, rng: Generator, seen: Seen, points: Array) -> Array:
        return along_rays(seen, points, self.size * seen.weight * self.field.draw(rng, seen.points))

    def covariance(self, seen: Seen) -> Array:
        return outer(self.size * seen.weight * seen.slope) * self.field.correlation(distances(seen.points))


@dataclass(frozen=True)
class LineOffsets:
    """Each scan line, ring or row of hits is off by its own normal error along the rays."""

    size: float
    name: ClassVar[str] = "line offsets"

    def applied(self, rng: Generator, seen: Seen, points: Array) -> Array:
        lines, place = np.unique(seen.line, return_inverse=True)
        return along_rays(seen, points, self.size * rng.standard_normal(len(lines))[place])

    def covariance(self, seen: Seen) -> Array:
        return outer(self.size * seen.slope) * (seen.line[:, None] == seen.line)


@dataclass(frozen=True)
class LineWaves:
    """Waves along each line, independent of those of the next one: a smooth field of its own for each."""

    size: float
    length: float
    name: ClassVar[str] = "line waves"
    APART: ClassVar[float] = 4.0
    """Lines lie so many lengths apart in the field: it is e^-8 there."""

    def places(self, seen: Seen) -> Array:
        return np.column_stack([seen.along / self.length, self.APART * seen.line])

    def applied(self, rng: Generator, seen: Seen, points: Array) -> Array:
        return along_rays(seen, points, self.size * Smooth(1.0).draw(rng, self.places(seen)))

    def covariance(self, seen: Seen) -> Array:
        correlation = Smooth(1.0).correlation(distances(self.places(seen)))
        return outer(self.size * seen.slope) * correlation


@dataclass(frozen=True)
class Ripple:
    """Parallel waves of one period across the image, as a projector's stripes leave them."""

    size: float
    period: float
    """As a tangent in the image."""
    name: ClassVar[str] = "ripple"

    def phase(self, seen: Seen) -> Array:
        return 2 * np.pi * seen.image[:, 0] / self.period

    def applied(self, rng: Generator, seen: Seen, points: Array) -> Array:
        waves = np.cos(self.phase(seen) + rng.uniform(0.0, 2 * np.pi))
        return along_rays(seen, points, self.size * np.sqrt(2.0) * waves)

    def covariance(self, seen: Seen) -> Array:
        phase = self.phase(seen)
        return outer(self.size * seen.slope) * np.cos(phase[:, None] - phase)


@dataclass(frozen=True)
class RadialBow:
    """Depth that is wrong with the square of the distance from the middle of the image, either way."""

    size: float
    name: ClassVar[str] = "radial bow"

    @staticmethod
    def form(seen: Seen) -> Array:
        return standardised(np.sum(seen.image**2, axis=1))

    def applied(self, rng: Generator, seen: Seen, points: Array) -> Array:
        return along_rays(seen, points, self.size * rng.choice([-1.0, 1.0]) * self.form(seen))

    def covariance(self, seen: Seen) -> Array:
        return outer(self.size * seen.slope * self.form(seen))


@dataclass(frozen=True, eq=False)
class FormDeviation:
    """What the part itself is off its ideal, along the normals: bowed, barrelled, lobed."""

    size: float
    patch: Patch
    waves: int
    """0: bowed or barrelled; else so many lobes around."""
    phase: float
    name: ClassVar[str] = "form"

    def form(self, seen: Seen) -> Array:
        return standardised(form_of(self.patch, self.waves, self.phase, seen.points))

    def applied(self, rng: Generator, seen: Seen, points: Array) -> Array:
        error = self.size * rng.choice([-1.0, 1.0]) * self.form(seen)
        return points + error[:, None] * seen.normals

    def covariance(self, seen: Seen) -> Array:
        return outer(self.size * self.form(seen))


def form_of(patch: Patch, waves: int, phase: float, points: Array) -> Array:
    """A bow (of planes: along a direction, or in both), a barrel over the height, or lobes around."""
    x, y, z = points.T
    match patch.primitive:
        case Plane():
            u, v = np.cos(phase) * x + np.sin(phase) * y, np.cos(phase) * y - np.sin(phase) * x
            return u**2 + (v**2 if waves else 0.0)
        case Sphere():
            return (points @ [np.sin(phase), 0.0, np.cos(phase)]) ** 2
        case Torus(major_radius=major_radius):
            return np.cos(max(waves, 2) * np.arctan2(z, np.hypot(x, y) - major_radius) + phase)
    if waves:
        return np.cos(waves * np.arctan2(y, x) + phase)
    middle = (patch.v[0] + patch.v[1]) / 2
    return (z - middle) ** 2


@dataclass(frozen=True)
class StationShift:
    """Stations are registered with an error: all points of one are moved together, a double wall."""

    size: float
    """Standard deviation on each axis [m]."""
    name: ClassVar[str] = "station shift"

    def applied(self, rng: Generator, seen: Seen, points: Array) -> Array:
        count = int(seen.station.max()) + 1
        shifts = self.size * rng.standard_normal((count, 3))
        shifts[0] = 0.0
        return points + shifts[seen.station]

    def covariance(self, seen: Seen) -> Array:
        moved = (seen.station[:, None] == seen.station) & (seen.station > 0)
        return self.size**2 * (seen.normals @ seen.normals.T) * moved


@dataclass(frozen=True)
class DepthSteps:
    """Depth z is a whole number of disparities: steps of `coefficient` z^2."""

    size: float
    coefficient: float
    """[1/m]: 1 / z is a multiple of it."""
    name: ClassVar[str] = "depth steps"

    def applied(self, rng: Generator, seen: Seen, points: Array) -> Array:
        moved = np.einsum("ij,ij->i", points - seen.points, seen.rays)
        depth = (seen.distance + moved) * seen.depth
        stepped = 1.0 / (np.maximum(np.round(1.0 / depth / self.coefficient), 1.0) * self.coefficient)
        return along_rays(seen, points, (stepped - depth) / seen.depth)

    def covariance(self, seen: Seen) -> Array:
        """That of uniform errors, independent: noise of a third of a step makes them so (Widrow, 1956)."""
        steps = self.coefficient * seen.distance**2 * seen.depth
        return np.diag((steps * seen.slope) ** 2 / 12.0)
