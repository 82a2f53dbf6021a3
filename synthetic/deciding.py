"""Whether the kind of a piece can be told under the errors of its sensor: what the truth gains on others.

With residuals d of the clean points about the nearest surface of another kind, their Jacobian J and the
covariance C of all errors across the surface, whoever knows C and fits by generalised least squares sees
the truth ahead by a log-likelihood of

    g = 1/2 d' (C^-1 - C^-1 J (J' C^-1 J)^-1 J' C^-1) d

on the average, with a standard deviation of sqrt(2 g): it is the log ratio of two normal laws of the same
covariance.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

from .canonical import ORIGIN
from .effects import Effect, Seen, White
from .patches import Patch
from .telling import nearest_cones, nearest_cylinders, settled

Array = NDArray[np.float64]

LEAST_GAIN = 20.0
"""What the truth gains on the nearest rival at least.

A more general truth starts some 8 behind (Occam's factor of one to three parameters that are known to a few
per cent), so this is 12 more than needed: two standard deviations of sqrt(2 g) = 6.3. Whoever knows the
errors is wrong in 3% of the clouds at this limit, and most are far from it.
"""
MOST_NOISE = 0.03
"""Of all errors together across the surface, root mean square, in extents: segmentation would not have found
what scatters more, and a thin tube wraps it."""
SPHERE_STEPS = 5
"""Gauss-Newton steps from the algebraic sphere to the nearest one."""
ENOUGH = 150
"""Points that gains are computed from; each stands for its share of all, so white noise counts less."""


def about_plane(points: Array) -> tuple[Array, Array]:
    """Distances (N,) from the best plane and their derivatives (N, 3)."""
    centered = points - points.mean(axis=0)
    axes = np.linalg.svd(centered, full_matrices=False)[2]
    return centered @ axes[2], np.column_stack([np.ones(len(points)), centered @ axes[:2].T])


def about_sphere(points: Array) -> tuple[Array, Array]:
    """Distances (N,) from the best sphere and their derivatives (N, 4).

    Gauss-Newton from the algebraic sphere  |x|^2 = 2 c.x + b.
    """
    centered = points - points.mean(axis=0)
    design = np.column_stack([2.0 * centered, np.ones(len(points))])
    solution = np.linalg.lstsq(design, np.einsum("ij,ij->i", centered, centered), rcond=None)[0]
    center, radius = solution[:3], np.sqrt(max(solution[3] + solution[:3] @ solution[:3], 0.0))
    for _ in range(SPHERE_STEPS + 1):
        outwards = centered - center
        lengths = np.linalg.norm(outwards, axis=1)
        residual = lengths - radius
        jacobian = -np.column_stack([outwards / lengths[:, None], np.ones(len(points))])
        step = np.linalg.lstsq(jacobian, -residual, rcond=None)[0]
        center, radius = center + step[:3], radius + step[3]
    return residual, jacobian


def rivals_of_a_sphere(sphere: Sphere, points: Array) -> Iterator[Cylinder | Cone]:
    """Where to look for cylinders and cones near a piece of a sphere: touching it, and about its middle."""
    middle = points.mean(axis=0)
    up = middle / max(float(np.linalg.norm(middle)), 1e-12)
    first, second = np.linalg.svd(points - middle, full_matrices=False)[2][:2]
    for axis in (first, second):
        yield Cylinder(axis, ORIGIN, sphere.radius)
    height, rho = points @ up, np.linalg.norm(points - np.outer(points @ up, up), axis=1)
    slope, offset = np.polyfit(height, rho, 1)
    slope = float(np.copysign(max(abs(slope), 0.02), slope))
    yield Cone(-offset / slope * up, np.sign(slope) * up, float(np.arctan(abs(slope))))


def rivals(patch: Patch, points: Array) -> Iterator[tuple[Array, Array]]:
    """Distances and derivatives of the nearest surfaces of the kinds that do not hold this one as a limit."""
    primitive = patch.primitive
    if isinstance(primitive, Plane):
        return
    yield about_plane(points)
    starts: list[Cylinder | Cone] = []
    if isinstance(primitive, Sphere):
        starts += rivals_of_a_sphere(primitive, points)
    else:
        yield about_sphere(points)
    if isinstance(primitive, Cone | Torus):
        starts += nearest_cylinders(patch, points)
    if isinstance(primitive, Torus):
        starts += nearest_cones(primitive, points)
    for start in starts:
        found = settled(start, points)
        yield found.fun, found.jac


def covariance(effects: list[Effect], seen: Seen, share: float) -> Array:
    """Of all errors across the surface, (N, N), where each of the points stands for 1 / share of all."""
    total = np.zeros((len(seen.points), len(seen.points)))
    for effect in effects:
        total += (share if isinstance(effect, White) else 1.0) * effect.covariance(seen)
    floor = 1e-9 * seen.extent
    return total + (floor**2 + 1e-6 * np.trace(total) / len(total)) * np.eye(len(total))


def gain(patch: Patch, seen: Seen, total: Array) -> float:
    """The mean log-likelihood by which the truth leads the nearest rival; infinite where there is none."""
    root = np.linalg.cholesky(total)
    least = np.inf
    for residual, jacobian in rivals(patch, seen.points):
        white = solve_triangular(root, np.column_stack([residual, jacobian]), lower=True)
        left = white[:, 0] - white[:, 1:] @ np.linalg.lstsq(white[:, 1:], white[:, 0], rcond=1e-9)[0]
        least = min(least, float(left @ left) / 2.0)
    return least


def decidable(rng: np.random.Generator, patch: Patch, seen: Seen, effects: list[Effect]) -> bool:
    """Whether there is a surface to be seen, and the truth gains `LEAST_GAIN` on every rival."""
    count = min(ENOUGH, len(seen.points))
    few = seen.part(np.sort(rng.permutation(len(seen.points))[:count]))
    if np.sqrt(np.mean(np.diag(covariance(effects, few, 1.0)))) > MOST_NOISE * seen.extent:
        return False
    return gain(patch, few, covariance(effects, few, count / len(seen.points))) >= LEAST_GAIN
