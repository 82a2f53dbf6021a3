"""How far an answer is from the truth, and from the points.

Lengths are those of the cloud unless a measure is called relative; then they are shares of the cloud's
extent, the diagonal of the bounding box of the points that belong to the surface. Everything is computed
about the centroid, so that far coordinates cost no digits.
"""

import numpy as np

from primfit.fitting.cloud.frame import Frame
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.shrec22 import sampled_distances, to_vector
from primfit.fitting.solver.refine import refine

DIRECTIONS = {"plane": slice(0, 3), "cylinder": slice(1, 4), "cone": slice(1, 4), "torus": slice(2, 5)}
"""Where the direction stands in the track's vectors; its sign is free."""

COMPARED = {"plane": 3, "cylinder": 4}
"""How many leading parameters are compared: the point of a plane or a cylinder is not unique."""

GRID = 200
"""Samples in each direction of the sampled surface. The paper says "densely"; with so many, exact answers
come out about as its best methods do."""

MOST_SAMPLED = 20_000
"""Points that the sampled measures look at; of larger clouds every k-th."""

REFERENCE_STEPS = 500
"""Steps of the reference fit at most."""

TURN = 2 * np.pi


def is_right(status: str, found: Primitive | None, kind: str) -> bool:
    """Whether the kind is the true one; of a foreign shape, whether the status is `no_fit`.

    `ambiguous` and `no_fit` of a primitive count as wrong.
    """
    if kind == "foreign":
        return status == "no_fit"
    return status == "fitted" and found is not None and found.kind == kind


def l2(found: Primitive, truth: Primitive) -> float:
    """The track's L2 distance between parameter vectors of one kind, lengths and radians as they are.

    Minimized over the sign of the axis, with a torus's radii sorted; the points of planes and cylinders
    are left out. Source: Romanengo et al. 2022, section 2.2.2.
    """
    a, b = (_compared(primitive) for primitive in (found, truth))
    opposite = a.copy()
    if found.kind in DIRECTIONS:
        opposite[DIRECTIONS[found.kind]] *= -1.0
    return float(min(np.linalg.norm(a - b), np.linalg.norm(opposite - b)))


def _compared(primitive: Primitive) -> Array:
    vector = np.array(to_vector(primitive)[1])
    if primitive.kind == "torus":
        vector[:2] = np.sort(vector[:2])
    return vector[: COMPARED.get(primitive.kind)]


def position_error(found: Primitive, truth: Primitive, center: Array) -> float | None:
    """What L2 leaves out of planes and cylinders, free of the choice of their points; None for other kinds.

    Planes: difference of the signed distances from `center` (the cloud's centroid), the normals turned to the
    same side. Cylinders: distance of the found axis from the point of the true axis that lies closest to
    `center`.
    """
    match found, truth:
        case Plane(), Plane():
            offsets = [plane.signed_distance(center[None])[0] for plane in (found, truth)]
            side = 1.0 if found.normal @ truth.normal >= 0.0 else -1.0
            return float(abs(side * offsets[0] - offsets[1]))
        case Cylinder(), Cylinder():
            foot = truth.point + ((center - truth.point) @ truth.axis) * truth.axis
            return float(np.linalg.norm(np.cross(foot - found.point, found.axis)))
    return None


def distances(primitive: Primitive, points: Array) -> Array:
    """Orthogonal distances (N,) of points to the whole, unbounded surface."""
    return np.abs(primitive.signed_distance(points))


def surface_error(found: Primitive, truth: Primitive, points: Array) -> float:
    """Root mean square distance of the true surface to the found one where the cloud is.

    That is, of the points' closest points on the true surface. It compares any two kinds, counts positions
    that L2 leaves out, and no parameter that the cloud's part of the surface does not depend on.
    """
    on_truth = points - truth.signed_distance(points)[:, None] * truth.gradient(points)
    return float(np.sqrt(np.mean(found.signed_distance(on_truth) ** 2)))


def diagonal(points: Array) -> float:
    """Of the bounding box."""
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def fitting_errors(found: Primitive, points: Array) -> dict[str, float]:
    """What needs no truth, with exact distances.

    Returns
    -------
    mfe : mean distance of the points over the diagonal of their bounding box
    hausdorff : the largest distance (directed, from the points to the surface)
    """
    exact = distances(found, points)
    return {"mfe": float(exact.mean()) / diagonal(points), "hausdorff": float(exact.max())}


def sampled_errors(found: Primitive, points: Array) -> dict[str, float]:
    """`fitting_errors` with `sampled_distances`, as `mfe_sampled` and `hausdorff_sampled`."""
    sampled = sampled_distances(found, points[:: -(-len(points) // MOST_SAMPLED)], GRID)
    return {
        "mfe_sampled": float(sampled.mean()) / diagonal(points),
        "hausdorff_sampled": float(sampled.max()),
    }


def truth_errors(found: Primitive, truth: Primitive, points: Array) -> dict[str, float]:
    """What is measured against the truth, given the points that belong to the surface.

    Returns
    -------
    surface : `surface_error` over the extent of the points
    l2, relative_l2 : `l2` as it is, and with all lengths over the extent; only where the kind is right
    position, relative_position : `position_error`, and the same over the extent; only of planes and cylinders
    radius : the signed error of the radius over the true one; only of spheres and cylinders
    """
    size = diagonal(points)
    errors = {"surface": surface_error(found, truth, points) / size}
    if found.kind != truth.kind:
        return errors
    unit = [primitive.transformed(np.eye(3), np.zeros(3), 1.0 / size) for primitive in (found, truth)]
    errors |= {"l2": l2(found, truth), "relative_l2": l2(unit[0], unit[1])}
    position = position_error(found, truth, points.mean(axis=0))
    if position is not None:
        errors |= {"position": position, "relative_position": position / size}
    if isinstance(found, Sphere | Cylinder) and isinstance(truth, Sphere | Cylinder):
        errors["radius"] = found.radius / truth.radius - 1.0
    return errors


def reference_errors(truth: Primitive, points: Array, noise: float) -> dict[str, float]:
    """`truth_errors` of the reference fit, and what theory expects of its surface error.

    The reference is least squares on the points (N, 3) that belong to the surface, started at the truth.
    `expected` is  noise sqrt(dof / N)  over the extent. A fit off by the parameters p has the surface error
    |J p| / sqrt(N) to first order, with the derivatives J of the distances; the covariance of least squares
    is C = noise^2 (J^T J)^-1. So  surface / expected = sqrt(p^T C^-1 p / dof): covariance-normalized.
    """
    frame = Frame.of(points)
    start = truth.transformed(np.eye(3), -frame.center / frame.scale, 1.0 / frame.scale)
    found = refine(start, frame.normalize(points), max_iterations=REFERENCE_STEPS).primitive
    expected = noise * np.sqrt(truth.dof / len(points)) / diagonal(points)
    return truth_errors(frame.restore(found), truth, points) | {"expected": float(expected)}
