"""Sheets, pipes, balls and bars that tests of several rooms draw, and what an answer says of them."""

import numpy as np

from primfit.fitting.answer.result import Recognition
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cone import Cone


def rng(*seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def sheet(n: int, noise: float, seed: int, bow: float = 0.0) -> Array:
    """A square of side 1; a bow is the standard deviation of the dome that it is."""
    x, y = rng(seed, 0).uniform(-0.5, 0.5, (2, n))
    dome = x**2 + y**2
    height = bow * (dome - dome.mean()) / dome.std() + noise * rng(seed, 1).normal(size=n)
    return np.column_stack([x, y, height])


def pipe(n: int, noise: float, seed: int, arc: float = 2.0 * np.pi) -> Array:
    """Of radius 1 and length 2."""
    angle = rng(seed, 0).uniform(-arc / 2.0, arc / 2.0, n)
    radius = 1.0 + noise * rng(seed, 1).normal(size=n)
    return np.column_stack(
        [radius * np.cos(angle), radius * np.sin(angle), rng(seed, 2).uniform(-1.0, 1.0, n)]
    )


def ball(n: int, noise: float, seed: int) -> Array:
    """Of radius 1."""
    points = rng(seed, 0).normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return np.asarray(points * (1.0 + noise * rng(seed, 1).normal(size=(n, 1))))


def bar(faces: int, n: int, noise: float, seed: int) -> Array:
    """The sides of a prism along z, 2 radii long, without ends."""
    side, along = rng(seed, 0).integers(faces, size=n), rng(seed, 1).random(n)
    corners = np.exp(2j * np.pi * np.arange(faces + 1) / faces)
    places = corners[side] + along * (corners[side + 1] - corners[side])
    places = places + noise * rng(seed, 2).normal(size=n) * np.exp(2j * np.pi * (side + 0.5) / faces)
    return np.column_stack([places.real, places.imag, rng(seed, 3).uniform(-1.0, 1.0, n)])


def stray(points: Array, share: float, seed: int) -> Array:
    """The points with a share of them anywhere in their box."""
    count = round(share * len(points))
    anywhere = rng(seed).uniform(points.min(axis=0), points.max(axis=0), (count, 3))
    return np.vstack([anywhere, points[count:]])


def beside_a_plane(points: Array, share: float, noise: float, seed: int) -> Array:
    """The points with a share of them on a plane that touches the pipe or ball."""
    count = round(share * len(points))
    places, height = rng(seed, 0).uniform(-1.5, 1.5, (count, 2)), noise * rng(seed, 1).normal(size=count)
    return np.vstack([np.column_stack([places, 1.0 + height]), points[count:]])


def rings(noise: float = 0.0) -> Array:
    """Two of a cone."""
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    cone = Cone(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.5)
    points = np.vstack([cone.surface(angle, np.full(40, height)) for height in (1.0, 2.0)])
    return points + noise * rng(0).normal(size=points.shape)


def kinds(answer: Recognition) -> list[str]:
    """What the cloud may be, the best first; nothing where nothing fits."""
    if answer.status == "no_fit" or answer.primitive is None:
        return []
    return [answer.primitive.kind, *sorted(other.primitive.kind for other in answer.alternatives)]


def inlier_share(answer: Recognition) -> float:
    assert answer.error is not None
    return answer.error.inlier_share
