"""Pieces of every kind with known cuts, clean and with noise and outliers."""

from typing import Any

import numpy as np
import pytest

from primfit.fitting.extents import EXTENTS
from primfit.fitting.geometry.vectors import Array, basis
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config

Range = tuple[float, float]
TURN = 2.0 * np.pi
AXIS = np.array([0.2, -0.5, 0.8]) / np.linalg.norm([0.2, -0.5, 0.8])
PLANE = Plane(AXIS, [1.0, 2.0, 3.0])
SPHERE = Sphere([1.0, 2.0, 3.0], 1.5)
CYLINDER = Cylinder(AXIS, [1.0, 2.0, 3.0], 0.8)
CONE = Cone([1.0, 2.0, 3.0], AXIS, 0.4)
TORUS = Torus([1.0, 2.0, 3.0], AXIS, 2.0, 0.6)
OF_KIND: dict[str, Primitive] = {p.kind: p for p in (PLANE, SPHERE, CYLINDER, CONE, TORUS)}


def piece(primitive: Primitive, u: Range, v: Range, n: int, seed: int = 1) -> Array:
    """`n` points, evenly dense on the surface between two parameters each (a sphere's v is a polar angle)."""
    rng = np.random.default_rng(seed)
    across = rng.uniform(*u, n)
    along = rng.uniform(*v, n)
    match primitive:
        case Sphere():
            along = np.arccos(rng.uniform(np.cos(v[1]), np.cos(v[0]), n))
        case Cone():
            along = np.sqrt(rng.uniform(v[0] ** 2, v[1] ** 2, n))
        case Torus():
            weight = primitive.major_radius + primitive.minor_radius * np.cos(along)
            keep = rng.uniform(0, primitive.major_radius + primitive.minor_radius, n) < weight
            across, along = across[keep], along[keep]
    return primitive.surface(across, along)


def spoilt(points: Array, seed: int = 2) -> Array:
    """With noise of 0.1% of the diagonal, and 5% of the points anywhere in the bounding box."""
    rng = np.random.default_rng(seed)
    low, high = points.min(axis=0), points.max(axis=0)
    noisy = points + rng.normal(0.0, 1e-3 * np.linalg.norm(high - low), points.shape)
    noisy[: len(points) // 20] = rng.uniform(low, high, (len(points) // 20, 3))
    return noisy


def extents(points: Array, kind: str) -> Any:
    found = recognize(points, Config(kinds=(kind,)))
    assert found.status == "fitted", found.message
    assert type(found.extents) is EXTENTS[kind]
    return found.extents


SPOILS = {"clean": lambda points: points, "noise and outliers": spoilt}
spoils = pytest.mark.parametrize("spoil", SPOILS.values(), ids=SPOILS)


def check_arc(found: Any, primitive: Any, start: float, span: float) -> None:
    """The reference direction and the start angle lead to where the piece begins (or ends, axis reversed)."""
    assert found.reference_direction @ primitive.axis == pytest.approx(0.0, abs=0.01)
    if span == TURN:
        assert found.start_angle == 0.0
        return
    u, v = basis(primitive.axis)
    beyond = np.cross(primitive.axis, found.reference_direction)
    if found.reference_direction @ u < 0.9:  # the other sign of the axis has another reference
        return
    at = np.cos(found.start_angle) * found.reference_direction + np.sin(found.start_angle) * beyond
    assert at @ (np.cos(start) * u + np.sin(start) * v) > np.cos(0.01 * span)


def apart(one: float, other: float) -> float:
    return abs((one - other + np.pi) % TURN - np.pi)
