"""Sphere, cylinder, cone and torus fitted to one cloud at once, roughly, as surfaces of revolution.

In the half-plane (height h, distance rho from the axis) a cylinder and a cone are lines, a sphere and a torus
circles: four problems of one shape, refined together by a few damped, reweighted Gauss-Newton steps. What
comes of it tells the kinds apart; the answer's fit is made elsewhere, with care.

The axis they start from is that of the linear line complex nearest to the normals: the normals of a surface
of revolution meet its axis (Pottmann and Wallner, "Computational Line Geometry", 2001, chapter 3).
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

COMPLEX_ITERATIONS = 3
STEPS = 4
DAMPING = 1e-3
LONGEST_STEP = 0.5
"""In radians and in rms radii of the cloud."""
KERNEL_WIDTH = 2.0
"""Scale of the Geman-McClure weights, in medians of the absolute residual."""
FLOOR = 1e-6
OUTLYING = 9.0
"""Squared residuals are counted up to this many squared scales."""

FITTED = ("sphere", "cylinder", "cone", "torus")
COMPARED = ("plane", *FITTED)
ACTIVE = np.array(
    [  # tilts, shifts, along (height of a circle's centre, or inclination), major radius, distance
        [0, 0, 1, 1, 1, 0, 1],
        [1, 1, 1, 1, 0, 0, 1],
        [1, 1, 1, 1, 1, 0, 1],
        [1, 1, 1, 1, 1, 1, 1],
    ],
    dtype=np.float64,
)
AVERAGED = np.kron(np.diag([1.0, 1.0, 0.0, 0.0]), np.full((2, 2), 0.5))[:7, :7] + np.diag(
    [0.0] * 4 + [1.0] * 3
)
"""Both tilts, and both shifts, are damped alike: the frame's turn about its axis must not matter."""
N_REVOLUTION = 4 + 2 * len(COMPARED) + len(COMPARED) * (len(COMPARED) - 1) // 2 + 5
UPPER = np.triu_indices(len(COMPARED), 1)


def line_complex(points: Array, normals: Array) -> tuple[Array, Array, Array]:
    """The line that the normals miss least: a point of it, its direction, and three eigenvalues.

    Minimises  sum w ((x cross n) . c + n . m)^2  over |c| = 1 and m, with w = 1 / (residual + median / 2).
    """
    moments = np.empty((len(points), 6))
    moments[:, :3] = np.cross(points, normals)
    moments[:, 3:] = normals
    weights = np.full(len(points), 1.0 / len(points))
    for _ in range(COMPLEX_ITERATIONS):
        scatter = (moments * weights[:, None]).T @ moments
        lower = np.linalg.solve(scatter[3:, 3:] + 1e-9 * np.eye(3), scatter[3:, :3])
        values, vectors = np.linalg.eigh(scatter[:3, :3] - scatter[:3, 3:] @ lower)
        direction = vectors[:, 0]
        moment = -lower @ direction
        residual = np.abs(moments @ np.concatenate([direction, moment]))
        weights = 1.0 / (residual + 0.5 * _median(residual) + FLOOR)
        weights /= weights.sum()
    return np.cross(direction, moment), direction, values


def _median(values: Array) -> Array:
    middle = values.shape[-1] // 2
    return np.partition(values, middle, axis=-1)[..., middle]


def _frame(direction: Array) -> Array:
    """Columns u, v, direction."""
    other = np.eye(3)[int(np.argmin(np.abs(direction)))]
    u = np.cross(direction, other)
    u /= np.sqrt(u @ u)
    return np.column_stack([u, np.cross(direction, u), direction])


def _weighted(design: Array, target: Array) -> Array:
    """Reweighted least squares, three rounds."""
    weights = np.full(len(target), 1.0 / len(target))
    for _ in range(3):
        weighted = design * weights[:, None]
        solution = np.linalg.solve(weighted.T @ design + 1e-9 * np.eye(design.shape[1]), weighted.T @ target)
        weights = _robust(design @ solution - target)
    return solution


def start(points: Array, anchor: Array, direction: Array) -> tuple[Array, Array, Array]:
    """Anchors (4, 3), frames (4, 3, 3) and profiles (4, 3) to refine from.

    A profile is (inclination or height of the centre, major radius, distance or radius).
    """
    frame = _frame(direction)
    local = (points - anchor) @ frame
    h, rho = local[:, 2], np.sqrt(local[:, 0] ** 2 + local[:, 1] ** 2)
    one = np.ones(len(h))
    slope, offset = _weighted(np.stack([h, one], axis=1), rho)
    inclination = float(np.arctan(slope))
    a, b, c = _weighted(np.stack([h, rho, one], axis=1), h * h + rho * rho)
    tube = float(np.sqrt(max(c + (a * a + b * b) / 4, 1e-4)))
    x, y, z, w = _weighted(np.column_stack([points, one]), np.einsum("ij,ij->i", points, points))
    center = np.array([x, y, z]) / 2
    ball = float(np.sqrt(max(w + center @ center, 1e-4)))
    anchors = np.stack([center, anchor, anchor, anchor])
    frames = np.stack([frame] * 4)
    profiles = np.array(
        [
            [0.0, 0.0, min(ball, 1e3)],
            [0.0, 0.0, float(_median(rho))],
            [inclination, 0.0, offset * np.cos(inclination)],
            [a / 2, np.clip(b / 2, -1e3, 1e3), min(tube, 1e3)],
        ]
    )
    return anchors, frames, profiles


def profile_residuals(h: Array, rho: Array, profiles: Array) -> tuple[Array, Array, Array]:
    """Residuals (4, N), and the unit normals of the profiles: their parts along rho and along h."""
    outward, upward, residual = np.empty_like(rho), np.empty_like(rho), np.empty_like(rho)
    cosine, sine = np.cos(profiles[1:3, :1]), np.sin(profiles[1:3, :1])
    outward[1:3], upward[1:3] = cosine, -sine
    residual[1:3] = cosine * rho[1:3] - sine * h[1:3] - profiles[1:3, 2:]
    x, y = rho[::3] - profiles[::3, 1:2], h[::3] - profiles[::3, :1]
    length = np.sqrt(x * x + y * y) + FLOOR
    outward[::3], upward[::3] = x / length, y / length
    residual[::3] = length - profiles[::3, 2:]
    return residual, outward, upward


def refine(points: Array, anchors: Array, frames: Array, profiles: Array) -> tuple[Array, Array]:
    """Profiles (4, 3) and residuals (4, N) after `STEPS` damped, reweighted Gauss-Newton steps."""
    columns = np.ascontiguousarray(points.T)
    jacobian = np.empty((4, 7, len(points)))
    jacobian[:, 6] = -1.0
    for step in range(STEPS + 1):
        local = frames.transpose(0, 2, 1) @ (columns - anchors[..., None])
        h, rho = local[:, 2], np.sqrt(local[:, 0] ** 2 + local[:, 1] ** 2) + FLOOR
        residual, outward, upward = profile_residuals(h, rho, profiles)
        if step == STEPS:
            break
        weights = _robust(residual)
        radial = local[:, :2] / rho[:, None]
        turning = upward * rho - outward * h
        np.multiply(radial, turning[:, None], out=jacobian[:, :2])
        np.multiply(radial, -outward[:, None], out=jacobian[:, 2:4])
        np.negative(upward, out=jacobian[:, 4])
        jacobian[2, 4] = turning[2]
        np.negative(outward, out=jacobian[:, 5])
        weighted = jacobian * weights[:, None]
        normal = (weighted @ jacobian.transpose(0, 2, 1)) * ACTIVE[:, :, None] * ACTIVE[:, None, :]
        gradient = (weighted @ residual[..., None]) * ACTIVE[..., None]
        diagonal = normal.diagonal(0, 1, 2) @ AVERAGED
        normal[:, range(7), range(7)] += DAMPING * diagonal + FLOOR + (1.0 - ACTIVE)
        move = -np.linalg.solve(normal, gradient)[..., 0]
        length = np.sqrt(np.sum(move * move, axis=1, keepdims=True))
        move = move * np.minimum(1.0, LONGEST_STEP / (length + FLOOR))
        anchors = anchors + (frames[..., :2] @ move[:, 2:4, None])[..., 0]
        profiles = profiles + move[:, 4:]
        frames = np.matmul(frames, _rotations(move[:, :2]))
    return profiles, residual


def _robust(residual: Array) -> Array:
    """Geman-McClure weights (..., N) that sum to one."""
    size = np.abs(residual)
    size = size / (KERNEL_WIDTH * _median(size)[..., None] + FLOOR)
    weights: Array = 1.0 + size * size
    weights = 1.0 / (weights * weights)
    normalized: Array = weights / weights.sum(axis=-1, keepdims=True)
    return normalized


def _rotations(tilts: Array) -> Array:
    """Rotations (K, 3, 3) that turn z by about the tilts (K, 2) towards x and y: Cayley's map."""
    half = np.zeros((len(tilts), 3, 3))
    half[:, :2, 2] = tilts / 2
    half[:, 2, :2] = -tilts / 2
    return np.asarray(np.linalg.solve(np.eye(3) - half, np.eye(3) + half), np.float64)


def plane_residuals(points: Array) -> Array:
    """Signed distances from a reweighted plane, (N,)."""
    weights = np.full(len(points), 1.0 / len(points))
    for _ in range(3):
        centered = points - weights @ points
        normal = np.linalg.eigh((centered * weights[:, None]).T @ centered)[1][:, 0]
        residual = centered @ normal
        weights = _robust(residual)
    return residual


def revolution_features(points: Array, normals: Array) -> Array:
    """The line complex, how far each of five kinds is from the points, how the distances compare, and shapes.

    Parameters
    ----------
    points : (N, 3), centred, with rms radius 1
    normals : (N, 3), signs arbitrary

    Returns
    -------
    (N_REVOLUTION,)
    """
    anchor, direction, values = line_complex(points, normals)
    anchor = anchor * np.minimum(1.0, 1e3 / (np.sqrt(anchor @ anchor) + FLOOR))
    profiles, residuals = refine(points, *start(points, anchor, direction))
    squared = np.vstack([plane_residuals(points)[None], residuals]) ** 2
    squared = np.minimum(np.nan_to_num(squared, nan=1.0), 1.0)
    median = np.sqrt(_median(squared))
    mean = np.mean(np.sqrt(squared), axis=1)
    scale = max(float(median.min()) * 1.48, 1e-5)
    cost = np.minimum(squared / scale**2, OUTLYING).sum(axis=1) / 2.0
    sphere, cylinder, cone, torus = profiles
    return np.concatenate(
        [
            np.log10(np.maximum(values, 0.0) + FLOOR),
            [np.log10(len(points))],
            np.log10(median + 1e-5),
            np.log10(mean + 1e-5),
            np.arcsinh(cost[UPPER[0]] - cost[UPPER[1]]),
            [
                np.log10(abs(sphere[2]) + 1e-2),
                np.log10(abs(cylinder[2]) + 1e-2),
                np.abs(np.sin(cone[0])),
                np.log10(abs(torus[2]) + 1e-2),
                np.tanh(torus[1] / (abs(torus[2]) + 1e-2)),
            ],
        ]
    )
