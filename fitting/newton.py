"""The last digits of an optimum, by Newton's method on the gradient of the cost.

Levenberg-Marquardt judges a step by the cost, in which a step of 1e-8 uncertainties does not show, and comes
nearer by a constant factor only where residuals are large beside the radii of curvature.
"""

import numpy as np

from fitting.geometry import TINY, Array
from fitting.kernels import Kernel
from fitting.primitives import Primitive
from fitting.refine import linearize, linearize_along, stepped

ROUNDS, STEPS = 6, 12
"""Times at most that curvature is taken, and steps by each; where it is known well, one and three."""

AT_REST = 1e-9
"""A round whose first step is shorter than this, in norms of the distances, is the last one."""

CURVATURE_POINTS = 20_000
"""Curvature is taken on every k-th point of a cloud of more: an error in it only costs steps."""

DIFFERENCE = 1e-3
"""Width of the differences, in rms distances: under noise that is well within what is linear."""

UNCURVED = 1e-9
"""Below this rms distance, in the normalised frame, curvature is neither seen nor needed."""

UNSEEN = 1e-12
"""Relative growth of the cost that is rounding."""

SMALLEST_PIVOT = 1e-12
"""Relative size of a direction below which the points do not determine the surface."""


def newton(primitive: Primitive, points: Array, kernel: Kernel, scale: float = 1.0) -> Primitive:
    """The stationary point of  sum rho(d / scale)  that the primitive is close to.

    The primitive itself comes back where it is near no minimum.
    """
    for _ in range(ROUNDS):
        moved, length = _round(primitive, points, kernel, scale)
        if not _cost(moved, points, kernel, scale) <= _cost(primitive, points, kernel, scale) * (
            1.0 + UNSEEN
        ):
            break
        primitive = moved
        if length <= AT_REST:
            break
    return primitive


def _cost(primitive: Primitive, points: Array, kernel: Kernel, scale: float) -> float:
    return float(kernel.rho((primitive.signed_distance(points) / scale) ** 2).sum())


def _round(primitive: Primitive, points: Array, kernel: Kernel, scale: float) -> tuple[Primitive, float]:
    """The surface after steps with one curvature, and the length of the first in norms of the distances.

    Coordinates are those in which the weighted derivatives are orthonormal: J = Q R, y = R step. There the
    gradient is  g = R^-T J^T W d,  and its derivative, taken by central differences, is near the identity
    even on short arcs.
    """
    distance, jacobian = linearize(primitive, points)
    weight = kernel.weight((distance / scale) ** 2)
    triangle = np.linalg.qr(np.sqrt(weight)[:, None] * jacobian, mode="r")
    sizes = np.abs(np.diag(triangle))
    if len(sizes) < primitive.dof or not sizes.min() > SMALLEST_PIVOT * sizes.max():
        return primitive, 0.0
    whitening = np.linalg.inv(triangle)

    def gradient(y: Array, points: Array) -> Array:
        moved = stepped(primitive, whitening @ y)
        distance, jacobian = linearize_along(primitive, moved, points)
        return whitening.T @ (jacobian.T @ (kernel.weight((distance / scale) ** 2) * distance))

    curvature = np.eye(primitive.dof)
    rms = float(np.sqrt(np.mean(weight * distance**2)))
    if rms > UNCURVED:
        every = -(-len(points) // CURVATURE_POINTS)
        widths = DIFFERENCE * rms * np.sqrt(len(points)) * curvature
        differences = [gradient(y, points[::every]) - gradient(-y, points[::every]) for y in widths]
        curvature = every * np.array(differences) / (2.0 * widths[0, 0])
        curvature = 0.5 * (curvature + curvature.T)
    if not np.all(np.linalg.eigvalsh(curvature) > 0.0):
        return primitive, 0.0
    lengths = [np.inf]
    total = np.zeros(primitive.dof)
    for _ in range(STEPS):
        step = np.linalg.solve(curvature, gradient(total, points))
        lengths.append(float(np.linalg.norm(step)))
        if not lengths[-1] < 0.5 * lengths[-2]:
            break
        total -= step
    return stepped(primitive, whitening @ total), lengths[1] / (rms * np.sqrt(len(points)) + TINY)
