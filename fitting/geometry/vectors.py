"""Small vector geometry shared by the primitives: unit vectors, bases, signs and axes."""

import math

import numpy as np
from numpy.typing import NDArray

from . import _linear

Array = NDArray[np.float64]

SIGN_TOLERANCE = 1e-9
"""Components of a direction below this magnitude do not decide its sign."""

Z_AXIS: Array = np.array([0.0, 0.0, 1.0])

TINY = 1e-300
"""Added where a distance is divided by, so that points on an axis give 0 instead of NaN."""


def vector(values: object) -> Array:
    """A float64 copy of shape (3,) that nobody can change."""
    result = np.array(values, dtype=np.float64).reshape(3) + 0.0  # no negative zeros
    result.flags.writeable = False
    return result


def unit(values: object) -> Array:
    """`vector(values)` divided by its length; raises `ValueError` for a zero or non-finite vector."""
    x, y, z = direction = np.array(values, dtype=np.float64).reshape(3).tolist()
    largest = max(abs(x), abs(y), abs(z))
    if not all(map(math.isfinite, direction)) or largest == 0.0:
        raise ValueError(f"a direction needs a finite, non-zero vector, not {direction}")
    x, y, z = x / largest, y / largest, z / largest
    length = math.sqrt(x * x + y * y + z * z)
    return vector([x / length, y / length, z / length])


def cross(a: Array, b: Array) -> Array:
    """`numpy.cross` of (..., 3) arrays of one shape, several times as fast."""
    result = np.empty_like(a)
    for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        result[..., k] = a[..., i] * b[..., j] - a[..., j] * b[..., i]
    return result


def basis(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors that complete each unit vector `axis`, (3,) or (3, K), to a right-handed frame.

    Source: Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017, listing 3.
    """
    x, y, z = axis.tolist() if axis.ndim == 1 else axis
    sign = 1.0 - 2.0 * (z < 0.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    u = np.array([1.0 + sign * x * x * a, sign * b, -sign * x])
    v = np.array([b, sign + y * y * a, -y])
    return u, v


def canonical_direction(direction: Array) -> Array:
    """`direction` or its opposite: the one whose first component above `SIGN_TOLERANCE` is positive."""
    for component in direction:
        if abs(component) > SIGN_TOLERANCE:
            return vector(direction if component > 0.0 else -direction)
    return direction


def bounds(points: Array) -> Array:
    """The least and the greatest coordinates (2, 3) of points (N, 3)."""
    return _linear.bounds(np.ascontiguousarray(points, np.float64))[0]


def principal(points: Array) -> tuple[Array, Array]:
    """Root mean square extents (3,) of points (N, 3) about their centroid, the largest first, and the unit
    directions (3, 3) that they are along, in columns; of either sign."""
    _, sizes, directions = np.linalg.svd(_linear.triangle_of(np.ascontiguousarray(points)))
    return sizes / math.sqrt(len(points)), directions.T


def around_axis(points: Array, origin: Array, axis: Array) -> tuple[Array, Array, Array]:
    """Cylindrical coordinates of points about an axis line.

    Returns
    -------
    radial : (N, 3) vectors from the axis to the points, orthogonal to it
    rho : (N,) their lengths
    height : (N,) signed positions along the axis, 0 at `origin`
    """
    relative = points - origin
    height = relative @ axis
    radial = relative - height[:, None] * axis
    rho = np.sqrt(np.einsum("ij,ij->i", radial, radial))
    return radial, rho, height


def cylindrical(points: Array, origin: Array, axis: Array) -> tuple[Array, Array, Array]:
    """Azimuth (N,) [rad] in the basis of the axis, distance from it, and height above `origin`."""
    radial, rho, height = around_axis(points, origin, axis)
    u, v = basis(axis)
    return np.arctan2(radial @ v, radial @ u), rho, height


def rows(
    directions: Array,
    anchors: Array,
    angle: Array | float = 0.0,
    major: Array | float = 0.0,
    offset: Array | float = 0.0,
) -> Array:
    """The nine numbers of a surface in `fitting.solver._descent`, (9,); or those of K surfaces, (K, 9)."""
    result = np.empty((*directions.shape[:-1], 9))
    result[..., :3], result[..., 3:6] = directions, anchors
    result[..., 6], result[..., 7], result[..., 8] = angle, major, offset
    return result


def foot_of_origin(point: Array, axis: Array) -> Array:
    """The point of the line through `point` along `axis` that lies closest to the origin."""
    foot = point - (point @ axis) * axis
    return foot - (foot @ axis) * axis
