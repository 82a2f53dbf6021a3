"""Slow and independent optima that the fits are held against; nothing here is shared with `fitting`.

Surfaces are dicts of parameters. Distances are taken in `numpy.longdouble` (64 bits of mantissa on x86),
straight from the definitions, and derivatives by differences of them.
"""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Array = NDArray[np.float64]
Long = NDArray[np.longdouble]
Surface = dict[str, Long]

NUMBERS = {
    "plane": ("shift",),
    "sphere": ("radius",),
    "cylinder": ("radius",),
    "cone": ("along", "half_angle"),
    "torus": ("along", "major_radius", "minor_radius"),
}
"""What is stepped beside the tilt of the direction and the shift of the anchor across it."""

ANCHOR = {"plane": "point", "sphere": "center", "cylinder": "point", "cone": "apex", "torus": "center"}
DIRECTION = {"plane": "normal", "cylinder": "axis", "cone": "axis", "torus": "axis"}
DOF = {"plane": 3, "sphere": 4, "cylinder": 5, "cone": 6, "torus": 7}


def long(surface: Mapping[str, object]) -> Surface:
    """The parameters, as `fitting.primitives.parameters` names them, in long double."""
    return {name: np.asarray(value, np.longdouble) for name, value in surface.items() if name != "kind"}


def distances(kind: str, surface: Surface, points: Long) -> Long:
    """Signed orthogonal distances (N,)."""
    x = points - surface[ANCHOR[kind]]
    if kind == "sphere":
        return np.sqrt(np.sum(x * x, axis=1)) - surface["radius"]
    direction = surface[DIRECTION[kind]]
    direction = direction / np.sqrt(np.sum(direction * direction))
    height = np.sum(x * direction, axis=1)
    if kind == "plane":
        return height
    across = x - height[:, None] * direction
    rho = np.sqrt(np.sum(across * across, axis=1))
    if kind == "cylinder":
        return rho - surface["radius"]
    if kind == "cone":
        sine, cosine = np.sin(surface["half_angle"]), np.cos(surface["half_angle"])
        behind = height * cosine + rho * sine < 0
        return np.where(behind, np.hypot(rho, height), rho * cosine - height * sine)
    return np.hypot(rho - surface["major_radius"], height) - surface["minor_radius"]


def moved(kind: str, surface: Surface, step: Long) -> Surface:
    """The surface after a step (dof,) in a chart about it: tilts, shifts, numbers."""
    result, step = dict(surface), np.asarray(step, np.longdouble)
    if kind == "sphere":
        result["center"] = surface["center"] + step[:3]
        result["radius"] = surface["radius"] + step[3]
        return result
    direction = surface[DIRECTION[kind]] / np.sqrt(np.sum(surface[DIRECTION[kind]] ** 2))
    u = np.cross(direction, np.eye(3, dtype=np.longdouble)[np.argmin(np.abs(direction))])
    u = u / np.sqrt(np.sum(u * u))
    v = np.cross(direction, u)
    tilted = direction + step[0] * u + step[1] * v
    result[DIRECTION[kind]] = tilted / np.sqrt(np.sum(tilted * tilted))
    rest = step[2:]
    if kind != "plane":
        result[ANCHOR[kind]] = surface[ANCHOR[kind]] + rest[0] * u + rest[1] * v
        rest = rest[2:]
    for name, value in zip(NUMBERS[kind], rest, strict=True):
        if name in ("along", "shift"):
            result[ANCHOR[kind]] = result[ANCHOR[kind]] + value * direction
        else:
            result[name] = surface[name] + value
    return result


def derivatives(kind: str, surface: Surface, points: Long, about: Long | None = None) -> Long:
    """d distance / d step (N, dof) at the step `about`, by differences of fourth order."""
    about = np.zeros(DOF[kind], np.longdouble) if about is None else about
    width = np.longdouble(3e-5)

    def there(step: Long) -> Long:
        return distances(kind, moved(kind, surface, about + step), points)

    columns = []
    for unit in width * np.eye(DOF[kind], dtype=np.longdouble):
        near, far = there(unit) - there(-unit), there(2 * unit) - there(-2 * unit)
        columns.append((8 * near - far) / (12 * width))
    return np.stack(columns, axis=1)


def newton(kind: str, surface: Surface, points: Long, steps: int = 12) -> Surface:
    """Newton's method on the sum of squares, with differences of the gradient for second derivatives.

    In coordinates in which the derivatives are orthonormal: features may be determined very weakly.
    """
    triangle = np.linalg.qr(derivatives(kind, surface, points).astype(np.float64), mode="r")
    whitening = np.linalg.inv(triangle).astype(np.longdouble)

    def gradient(surface: Surface, about: Long) -> Long:
        step = whitening @ about
        here = distances(kind, moved(kind, surface, step), points)
        return whitening.T @ (derivatives(kind, surface, points, step).T @ here)

    zero, units = np.zeros(DOF[kind], np.longdouble), np.eye(DOF[kind], dtype=np.longdouble)
    for _ in range(steps):
        width = np.longdouble(1e-6) * np.sqrt(np.sum(distances(kind, surface, points) ** 2)) + 1e-12
        hessian = np.stack([gradient(surface, width * u) - gradient(surface, -width * u) for u in units])
        hessian = (hessian / (2 * width)).astype(np.float64)
        step = np.linalg.solve(0.5 * (hessian + hessian.T), gradient(surface, zero).astype(np.float64))
        surface = moved(kind, surface, -(whitening @ step.astype(np.longdouble)))
        if np.linalg.norm(step) < 1e-18 * np.sqrt(len(points)):
            break
    return surface


def framed(kind: str, surface: Surface, center: Array, size: float) -> Surface:
    """The surface as seen from a centre, in units of a size."""
    result = {name: value / size if "radius" in name else value for name, value in surface.items()}
    result[ANCHOR[kind]] = (surface[ANCHOR[kind]] - center) / size
    return centred(kind, result)


def centred(kind: str, surface: Surface) -> Surface:
    """The same surface; a plane's point and that of a cylinder's axis are those closest to the origin."""
    if kind not in ("plane", "cylinder"):
        return surface
    point, direction = surface[ANCHOR[kind]], surface[DIRECTION[kind]]
    along = (point @ direction) * direction
    return surface | {ANCHOR[kind]: along if kind == "plane" else point - along}


def frame(points: Array) -> tuple[Array, float]:
    """Centroid and root mean square radius of points (N, 3)."""
    center = points.mean(axis=0)
    return center, float(np.sqrt(np.mean(np.sum((points - center) ** 2, axis=1))))


def near(
    kind: str, surface: Surface, count: int, rng: np.random.Generator, reach: float
) -> Iterator[Surface]:
    """The surface, and others about it that are ever farther away."""
    for width in np.linspace(0.0, reach, count):
        yield moved(kind, surface, rng.normal(0.0, 1.0, DOF[kind]) * width)


def misses(kind: str, one: Surface, other: Surface, center: Array) -> tuple[float, float]:
    """The largest difference in an angle and in a length; axes and cones are compared next to a centre.

    Of a cone that is the axis and the radius there: its apex may be metres away.
    """
    first, second = (_at(kind, surface, center) for surface in (one, other))
    angles = [np.linalg.norm(np.cross(first[0], second[0])), *np.abs(first[1] - second[1])]
    lengths = [np.linalg.norm(first[2] - second[2]), *np.abs(first[3] - second[3])]
    return float(max(angles)), float(max(lengths))


def _at(kind: str, surface: Surface, center: Array) -> tuple[Long, ...]:
    """Direction, angles, place and lengths of a surface as seen from a centre, in float64."""
    place, direction = surface[ANCHOR[kind]] - center, np.zeros(3, np.longdouble)
    if kind != "sphere":
        direction = surface[DIRECTION[kind]]
    height = place @ direction
    if kind == "plane":
        place = height * direction
    if kind in ("cylinder", "cone"):
        place = place - height * direction
    angles = [surface[name] for name in surface if name == "half_angle"]
    lengths = [surface[name] for name in surface if "radius" in name]
    if kind == "cone":
        lengths = [-height * np.tan(surface["half_angle"])]
    return tuple(np.array(each, np.float64) for each in (direction, angles, place, lengths))


def cost(kind: str, surface: Surface, points: Array) -> float:
    return float(np.sum(distances(kind, surface, points.astype(np.longdouble)) ** 2))


def least_squares_optimum(kind: str, starts: Iterable[Surface], points: Array) -> Surface:
    """The cheapest end of scipy's least squares from all starts, and then Newton in long double.

    Points are to be centred and of extent near 1.
    """
    long_points = points.astype(np.longdouble)
    ends = []
    for start in starts:
        found = least_squares(
            lambda step, start=start: distances(kind, moved(kind, start, step), long_points).astype(
                np.float64
            ),
            np.zeros(DOF[kind]),
            xtol=1e-15,
            ftol=1e-15,
            gtol=1e-15,
            x_scale="jac",
            max_nfev=400,
        )
        ends.append((found.cost, moved(kind, start, found.x)))
    least = min(end for end, _ in ends)
    best = [newton(kind, end, long_points) for found_cost, end in ends if found_cost <= least * (1.0 + 1e-6)]
    return min(best, key=lambda surface: cost(kind, surface, points))
