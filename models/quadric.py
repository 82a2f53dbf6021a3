"""A robust quadric through a cloud, and what of it no rigid motion changes.

Planes, spheres, cylinders and cones are quadrics, each with its own signs among the eigenvalues of the
quadratic part; a torus is none, and leaves residuals.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

Array = NDArray[np.float64]

ITERATIONS = 8
KERNEL_WIDTH = 1.5
"""Scale of the Geman-McClure weights, in medians of the absolute residual."""
FLOOR = 1e-6
"""Residuals and gradients below this share of the cloud's rms radius count as zero."""
RIDGE = 1e-6 * np.diag([1.0, 1.0, 1.0, 0.5, 0.5, 0.5, 1.0, 1.0, 1.0])
"""Added to the constraint, which is singular for points in one plane; the same in every rotated frame."""


def _gradients() -> Array:
    """D with  grad m_a = D[:, a] @ (x, y, z, 1)  for the nine monomials of `monomials`, shape (3, 9, 4)."""
    linear = np.zeros((3, 9, 4))
    for axis in range(3):
        linear[axis, axis, axis] = 2.0
        linear[axis, 6 + axis, 3] = 1.0
    for column, (i, j) in zip((3, 4, 5), ((0, 1), (0, 2), (1, 2)), strict=True):
        linear[i, column, j] = linear[j, column, i] = 1.0
    return linear


GRADIENTS = _gradients()


def monomials(points: Array) -> Array:
    """x2 y2 z2 xy xz yz x y z, shape (N, 9)."""
    x, y, z = points.T
    return np.stack([x * x, y * y, z * z, x * y, x * z, y * z, x, y, z], axis=1)


def fit_quadric(points: Array) -> tuple[Array, Array, Array, float]:
    """Taubin's fit, reweighted so that it locks on to the points that agree best.

    Minimises  sum w f^2 / sum w |grad f|^2  with Geman-McClure weights of the first-order distance
    |f| / |grad f|, whose scale follows its median. The constant of f makes its weighted mean zero.

    Parameters
    ----------
    points : (N, 3), centred, with rms radius 1

    Returns
    -------
    coefficients (9,) of `monomials`, distances (N,) to first order, the two smallest eigenvalues (2,) of
    the last step, and the median distance of the first, unweighted fit

    Source: Taubin, "Estimation of planar curves, surfaces, and nonplanar space curves defined by implicit
    equations", PAMI 13(11), 1991.
    """
    terms = monomials(points)
    linear = np.column_stack([points, np.ones(len(points))])
    weights = np.full(len(points), 1.0 / len(points))
    first_median = 0.0
    for iteration in range(ITERATIONS):
        centered = terms - weights @ terms
        scatter = (centered * weights[:, None]).T @ centered
        moments = (linear * weights[:, None]).T @ linear
        constraint = (GRADIENTS @ moments @ GRADIENTS.transpose(0, 2, 1)).sum(axis=0)
        values, vectors = eigh(
            scatter,
            constraint + RIDGE,
            subset_by_index=[0, 1],
            check_finite=False,
            overwrite_a=True,
            overwrite_b=True,
        )
        coefficients = vectors[:, 0]
        gradient = linear @ (GRADIENTS.transpose(0, 2, 1) @ coefficients).T
        slope = np.sqrt(np.einsum("ij,ij->i", gradient, gradient)) + FLOOR
        distance = np.abs(centered @ coefficients) / slope
        median = float(np.median(distance)) + FLOOR
        if iteration == 0:
            first_median = median
        weights = (1.0 + (distance / (KERNEL_WIDTH * median)) ** 2) ** -2
        weights /= weights.sum()
    return coefficients, distance, values, first_median


def quadric_features(points: Array) -> Array:
    """Nine numbers: the quadratic part's shape (3) and size, log10 of three distances and two eigenvalues."""
    coefficients, distance, values, first_median = fit_quadric(points)
    xx, yy, zz, xy, xz, yz = coefficients[:6]
    quadratic = np.array([[2 * xx, xy, xz], [xy, 2 * yy, yz], [xz, yz, 2 * zz]]) / 2.0
    eigenvalues = np.linalg.eigvalsh(quadratic)
    if eigenvalues.sum() < 0.0:
        eigenvalues = -eigenvalues[::-1]
    size = float(np.sqrt(eigenvalues @ eigenvalues))
    distances = [first_median, float(np.median(distance)), float(np.mean(distance))]
    return np.concatenate(
        [
            eigenvalues / (size + FLOOR),
            [size],
            np.log10(np.array(distances) + 10 * FLOOR),
            np.log10(np.abs(values) + FLOOR),
        ]
    )
