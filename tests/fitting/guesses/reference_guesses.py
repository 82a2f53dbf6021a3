"""What `primfit.fitting.guesses._guesses` computes, with NumPy."""

import numpy as np

from primfit.fitting.geometry.vectors import TINY, Array, around_axis, basis, rows


def solve(columns: Array, target: Array, rounds: int) -> Array:
    """One of the systems (m, N) of `robust_linear_solve`."""
    weight = np.ones(len(target))
    for _ in range(rounds):
        root = np.sqrt(weight)
        solution = np.linalg.lstsq((root * columns).T, root * target, rcond=None)[0]
        residual = solution @ columns - target
        weight = 1.0 / (1.0 + (residual / (np.median(np.abs(residual)) + 1e-12)) ** 2)
    return np.asarray(solution)


def circle(x: Array, y: Array, rounds: int) -> tuple[Array, float]:
    """Center and radius by Kasa's fit."""
    a, b, c = solve(np.stack([x, y, np.ones_like(x)]), x**2 + y**2, rounds)
    return np.array([a, b]) / 2.0, float(np.sqrt(c + (a**2 + b**2) / 4.0))


def cylinder(axis: Array, points: Array, rounds: int) -> Array:
    across = np.array(basis(axis))
    center, radius = circle(*(across @ points.T), rounds)
    return rows(axis, center @ across, offset=radius)


def cone(axis: Array, points: Array, rounds: int) -> Array:
    across = np.array(basis(axis))
    (x, y), height = across @ points.T, points @ axis
    a, b, m, e, _ = solve(np.stack([x, y, height**2, height, np.ones_like(x)]), x**2 + y**2, rounds)
    m = np.clip(m, 0.01, 100.0)
    apex, angle = -e / (2.0 * m), np.arctan(np.sqrt(m))
    side = 1.0 if np.median(height) > apex else -1.0
    return rows(side * axis, np.array([a, b]) / 2.0 @ across, angle, offset=-side * apex * np.sin(angle))


def torus(axis: Array, foot: Array, points: Array, rounds: int, smallest: float) -> Array:
    _, rho, height = around_axis(points, foot, axis)
    (major, level), minor = circle(rho, height, rounds)
    return rows(axis, foot + level * axis, major=max(abs(major), smallest), offset=minor)


def met(axis: Array, points: Array, normals: Array, rounds: int) -> Array:
    """Where lines along the normals meet an axis, in the plane across it through the origin."""
    u, v = basis(axis)
    columns = np.stack([normals @ v, -(normals @ u)])
    found = solve(columns, columns[0] * (points @ u) + columns[1] * (points @ v), rounds)
    return np.asarray(found @ np.array([u, v]))


def bent(cylinder: Array, points: Array, rounds: int, flattest: float) -> Array:
    axis, anchor, radius = cylinder[:3], cylinder[3:6], cylinder[8]
    across = np.array(basis(axis))
    seen, height = across @ (points - anchor).T, points @ axis
    middle = height.mean()
    height = height - middle
    rho = np.hypot(*seen) + TINY
    around = seen / rho
    columns = np.vstack([0.5 * height**2 * around, around, height * around, np.ones_like(rho)])
    found = solve(columns, rho - radius, rounds)
    if np.hypot(*found[:2]) < flattest:
        found[0] = flattest
    major = 1.0 / np.hypot(*found[:2])
    towards = major * found[:2] @ across
    normal = np.cross(axis + found[4:6] @ across, towards)
    on_axis = anchor + middle * axis + found[2:4] @ across
    return rows(
        normal / np.linalg.norm(normal), on_axis + major * towards, major=major, offset=radius + found[6]
    )


def tube(cylinder: Array, points: Array, normals: Array, rounds: int) -> Array:
    radial, rho, _ = around_axis(points, cylinder[3:6], cylinder[:3])
    side = np.where(np.einsum("ij,ij->i", radial, normals) < 0.0, -1.0, 1.0)
    off = np.abs(rho - cylinder[8])
    near = off <= 2.0 * np.median(off)
    spine = points[near] - cylinder[8] * side[near, None] * normals[near]
    center = spine.mean(axis=0)
    _, axes = np.linalg.eigh((spine - center).T @ (spine - center))
    across = axes.T[[2, 1]]
    middle, major = circle(*(across @ (spine - center).T), rounds)
    return rows(axes[:, 0], center + middle @ across, major=major, offset=cylinder[8])


def sphere(points: Array, rounds: int) -> Array:
    found = solve(np.vstack([points.T, np.ones(len(points))]), (points**2).sum(axis=1), rounds)
    center = found[:3] / 2.0
    return rows(np.array([0.0, 0.0, 1.0]), center, offset=np.sqrt(found[3] + center @ center))
