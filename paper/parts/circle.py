"""A circle in space by least squares of the distances to it, and the torus about it."""

import numpy as np
from scipy.optimize import least_squares

from primfit.fitting.geometry.vectors import TINY, Z_AXIS, Array, around_axis
from primfit.fitting.primitives.torus import Torus

START = np.array([0.0, 0.0, 0.0, *Z_AXIS, 1.0])
"""Center, axis and radius from which steps are taken, in a frame in which the cloud's longest side is 1."""


def off_circle(numbers: Array, points: Array) -> Array:
    """Distances (2 N,) of points (N, 3) from a circle, first in its plane, then across it."""
    axis = numbers[3:6] / (np.linalg.norm(numbers[3:6]) + TINY)
    _, rho, height = around_axis(points, numbers[:3], axis)
    return np.concatenate([rho - numbers[6], height])


def torus_about_circle(points: Array) -> Torus | None:
    """The torus whose tube has the mean distance of the points (N, 3) from their circle."""
    if len(points) < 3:
        return None
    numbers = least_squares(off_circle, START, args=(points,), x_scale="jac").x
    distances = np.hypot(*off_circle(numbers, points).reshape(2, -1))
    if not np.isfinite(numbers).all() or not np.any(numbers[3:6]):
        return None
    return Torus(numbers[:3], numbers[3:6], abs(numbers[6]), float(distances.mean()))
