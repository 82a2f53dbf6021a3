"""Newton's method in NumPy: the reference of `primfit.fitting.solver._newton`.

Levenberg-Marquardt judges a step by the cost, in which a step of 1e-8 uncertainties does not show, and comes
nearer by a constant factor only where residuals are large beside the radii of curvature.
"""

import numpy as np

from primfit.fitting.geometry.vectors import TINY, Array
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.solver.refine import linearize, linearize_along, stepped

ROUNDS, STEPS = 6, 12
"""Times at most that curvature is taken, and steps by each; where it is known well, one and three."""

AT_REST = 1e-9
"""A round whose first step is shorter than this, in norms of the distances, is the last one."""

CURVATURE_POINTS = 20_000
"""Curvature is taken on every k-th point of a cloud of more: an error in it only costs steps."""

DIFFERENCES = (1e-3, 1e-5)
"""Widths of the differences, in rms distances: under noise the first is well within what is linear, but for
directions that points determine very weakly. There the second is taken, if the curvature by the first is
that of no minimum."""

UNCURVED = 1e-9
"""Below this rms distance, in the normalized frame, curvature is neither seen nor needed."""

UNSEEN, UNSEEN_DISTANCE, MOST_UNSEEN = 1e-12, 1e-15, 1e-9
"""Growth that is rounding: of the cost, relatively, and of the distances; they add so much to it at most."""

SMALLEST_PIVOT = 1e-12
"""Relative size of a direction below which the points do not determine the surface."""


def newton(primitive: Primitive, points: Array, kernel: Kernel, scale: float = 1.0) -> Primitive:
    """The stationary point of  sum rho(d / scale)  that the primitive is close to.

    The primitive itself comes back where it is near no minimum.
    """
    for _ in range(ROUNDS):
        moved, length = _round(primitive, points, kernel, scale)
        before = _cost(primitive, points, kernel, scale)
        distance = scale * np.sqrt(2.0 * before / len(points)) + TINY
        unseen = UNSEEN + min(UNSEEN_DISTANCE / distance, MOST_UNSEEN)
        if not _cost(moved, points, kernel, scale) <= before * (1.0 + unseen):
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

    rms = float(np.sqrt(np.mean(weight * distance**2)))
    every = -(-len(points) // CURVATURE_POINTS)

    def curvature_by(width: float) -> Array:
        widths = width * rms * np.sqrt(len(points)) * np.eye(primitive.dof)
        differences = [gradient(y, points[::every]) - gradient(-y, points[::every]) for y in widths]
        found = every * np.array(differences) / (2.0 * widths[0, 0])
        return 0.5 * (found + found.T)

    curvatures = map(curvature_by, DIFFERENCES) if rms > UNCURVED else iter([np.eye(primitive.dof)])
    curvature = next((each for each in curvatures if np.all(np.linalg.eigvalsh(each) > 0.0)), None)
    if curvature is None:
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
