"""Write the sample scans again: `python samples/make.py` in a checkout with primfit installed.

Each sample is what a scanner at one place sees of a surface with known parameters: points on the side that
faces it, normally distributed noise along the surface normal, and a few stray points. README.md has the
truth.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import primfit

Points = NDArray[np.float64]

HERE = Path(__file__).parent


def scan(
    rng: np.random.Generator,
    surface: primfit.Primitive,
    u: tuple[float, float],
    v: tuple[float, float],
    n: int,
    noise: float,
    *,
    station: tuple[float, float, float] | None = None,
    stray: int = 0,
) -> Points:
    """Points (n, 3) of a piece of a surface, in the length unit of the surface.

    `u` and `v` are the ranges of the two parameters of `Primitive.surface`, `noise` the standard deviation
    along the normal. With `station` only the side that faces it is seen. The last `stray` points are uniform
    in the bounding box, widened by a tenth.
    """
    points = surface.surface(rng.uniform(*u, 4 * n), rng.uniform(*v, 4 * n))
    normals = surface.gradient(points)
    if station is not None:
        facing = np.einsum("ij,ij->i", normals, np.asarray(station) - points) > 0
        points, normals = points[facing], normals[facing]
    points = points[:n] + noise * rng.standard_normal((n, 1)) * normals[:n]
    if stray:
        low, high = points.min(axis=0), points.max(axis=0)
        points[-stray:] = rng.uniform(low - 0.1 * (high - low), high + 0.1 * (high - low), (stray, 3))
    return points


def turn(axis: tuple[float, float, float]) -> Points:
    """This direction as a unit vector."""
    return np.asarray(axis) / np.linalg.norm(axis)


# -- one function for each file ----------------------------------------------------------------------


def pipe() -> Points:
    """A pipe with an outside diameter of 114.3 mm (DN 100), seen from one side; mm."""
    surface = primfit.Cylinder(axis=turn((1.0, 0.2, 0.1)), point=[420.0, 130.0, 900.0], radius=57.15)
    return scan(
        np.random.default_rng(1), surface, (0, 2 * np.pi), (-300, 300), 2000, 0.3, station=(420, -2000, 1500)
    )


def tank_end() -> Points:
    """The spherical end of a tank, radius 1.25 m, a cap of 50 degrees, with stray points; m."""
    surface = primfit.Sphere(center=[12.0, 4.5, 2.2], radius=1.25)
    return scan(np.random.default_rng(2), surface, (0, 2 * np.pi), (0, np.radians(50)), 1500, 0.002, stray=30)


def floor() -> Points:
    """A floor of 6 m by 4 m that falls by 1 in 100, without the square of a column; m."""
    surface = primfit.Plane(normal=turn((0.01, 0.0, 1.0)), point=[3.0, 2.0, 0.12])
    points = scan(np.random.default_rng(3), surface, (-3, 3), (-2, 2), 1600, 0.003)
    column = (abs(points[:, 0] - 4.0) < 0.4) & (abs(points[:, 1] - 2.5) < 0.4)
    return points[~column]


def nozzle() -> Points:
    """A conical nozzle, half-angle 12 degrees, seen from one side; mm."""
    surface = primfit.Cone(apex=[80.0, 25.0, 300.0], axis=turn((0.0, 0.3, -1.0)), half_angle=np.radians(12.0))
    return scan(
        np.random.default_rng(4), surface, (0, 2 * np.pi), (90, 240), 1200, 0.08, station=(80, -800, 600)
    )


def handwheel() -> Points:
    """The rim of a handwheel, 320 mm across its center circle, 24 mm thick, from above; mm."""
    surface = primfit.Torus(
        center=[0.0, 0.0, 45.0], axis=turn((0.1, 0.0, 1.0)), major_radius=160.0, minor_radius=12.0
    )
    return scan(
        np.random.default_rng(5), surface, (0, 2 * np.pi), (0, 2 * np.pi), 1500, 0.1, station=(0, -300, 1500)
    )


def short_arc() -> Points:
    """A strip of a pipe, 12 degrees of its circumference: too short to tell a cylinder from a plane; mm."""
    surface = primfit.Cylinder(axis=[0.0, 1.0, 0.0], point=[0.0, 0.0, 0.0], radius=80.0)
    return scan(np.random.default_rng(6), surface, (0.0, np.radians(12)), (-15, 15), 400, 0.2)


def plate() -> Points:
    """A sheet of 300 mm by 200 mm, twisted so that its corners are 2 mm out of the plane; mm."""
    rng = np.random.default_rng(9)
    x, y = rng.uniform(-150, 150, 1200), rng.uniform(-100, 100, 1200)
    return np.column_stack([x, y, 2.0 * (x / 150) * (y / 100) + 0.1 * rng.standard_normal(1200)])


def oval_pipe() -> Points:
    """A pipe all around, out of round: its radius varies by 1.5 mm to either side; mm."""
    rng = np.random.default_rng(10)
    angle, height = rng.uniform(0, 2 * np.pi, 1500), rng.uniform(0, 400, 1500)
    radius = 57.15 + 1.5 * np.cos(2 * angle) + 0.2 * rng.standard_normal(1500)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


def corner() -> Points:
    """Two walls in one segment, with 60% and 40% of the points: no single primitive; m."""
    rng = np.random.default_rng(7)
    long = np.column_stack([np.zeros(600), rng.uniform(0, 2.4, 600), rng.uniform(0, 2.5, 600)])
    short = np.column_stack([rng.uniform(0, 1.6, 400), np.zeros(400), rng.uniform(0, 2.5, 400)])
    return np.vstack([long, short]) + 0.003 * rng.standard_normal((1000, 3))


def plant() -> tuple[Points, NDArray[np.int64]]:
    """A floor, an upright pipe, a spherical vessel and a conical hopper, apart; m, with labels."""
    rng = np.random.default_rng(8)
    up, seen_from = turn((0.0, 0.0, 1.0)), (2.0, -6.0, 1.7)
    base = primfit.Plane(normal=up, point=[2.0, 1.5, 0.0])
    post = primfit.Cylinder(axis=up, point=[0.6, 1.2, 1.3], radius=0.1095)
    vessel = primfit.Sphere(center=[2.1, 1.6, 1.1], radius=0.6)
    hopper = primfit.Cone(apex=[3.6, 1.4, 0.4], axis=up, half_angle=np.radians(25.0))
    around = (0, 2 * np.pi)
    parts = [
        scan(rng, base, (-2, 2), (-1.5, 1.5), 1500, 0.002),
        scan(rng, post, around, (-1, 1), 700, 0.002, station=seen_from),
        scan(rng, vessel, around, (0, np.pi), 900, 0.002, station=seen_from),
        scan(rng, hopper, around, (0.2, 1.1), 700, 0.002, station=seen_from),
    ]
    return np.vstack(parts), np.repeat([1, 2, 3, 4], [len(part) for part in parts])


# -- formats -----------------------------------------------------------------------------------------


def text(points: Points, digits: int, delimiter: str, header: str = "") -> bytes:
    """One point per line, with a fixed number of decimals."""
    lines = [delimiter.join(f"{value:.{digits}f}" for value in row) for row in points.tolist()]
    return "\n".join(([header] if header else []) + lines + [""]).encode()


def ply(points: Points) -> bytes:
    """Binary PLY in float32, as most scanner programs write it."""
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    head += "".join(f"property float {name}\n" for name in "xyz") + "end_header\n"
    return head.encode() + points.astype("<f4").tobytes()


def pcd(points: Points) -> bytes:
    """ASCII PCD of the Point Cloud Library."""
    n = len(points)
    head = f"""# .PCD v0.7 - Point Cloud Data file format
VERSION 0.7
FIELDS x y z
SIZE 4 4 4
TYPE F F F
COUNT 1 1 1
WIDTH {n}
HEIGHT 1
VIEWPOINT 0 0 0 1 0 0 0
POINTS {n}
DATA ascii
"""
    return head.encode() + text(points, 3, " ")


def labeled(points: Points, labels: NDArray[np.int64]) -> bytes:
    """CSV in meters with the segment of each point."""
    rows = zip(text(points, 4, ",").decode().splitlines(), labels.tolist(), strict=True)
    return "\n".join(["X [m],Y [m],Z [m],segment", *(f"{row},{label}" for row, label in rows), ""]).encode()


def samples() -> dict[str, bytes]:
    """The files by their names."""
    return {
        "pipe.ply": ply(pipe()),
        "tank-end.xyz": text(tank_end(), 4, " "),
        "floor.csv": text(floor(), 4, ",", "X [m],Y [m],Z [m]"),
        "nozzle.pcd": pcd(nozzle()),
        "handwheel.xyz": text(handwheel(), 3, " "),
        "short-arc.csv": text(short_arc(), 3, ",", "X [mm],Y [mm],Z [mm]"),
        "plate.csv": text(plate(), 3, ",", "X [mm],Y [mm],Z [mm]"),
        "oval-pipe.csv": text(oval_pipe(), 3, ",", "X [mm],Y [mm],Z [mm]"),
        "corner.xyz": text(corner(), 4, " "),
        "plant.csv": labeled(*plant()),
    }


def main() -> None:
    for name, content in samples().items():
        (HERE / name).write_bytes(content)


if __name__ == "__main__":
    main()
