"""Which more general kinds a cloud does not exclude: how far may the parameter go that nests a kind in them?

A plane is a sphere or a cylinder without curvature, a cylinder is a cone without an angle or a torus without
a bend, a sphere is a torus whose major radius is 0. To first order such a parameter k moves the surface by k
times a known function of the point. Its least squares estimate, beside the parameters of the simpler kind,
has a variance, and the interval of k says what the points leave open. Where that is a surface that differs in
practice, the points do not decide for the simpler kind.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fitting.axes import DIRECTION_GRID
from fitting.geometry import TINY, Array, around_axis, basis, principal
from fitting.primitives import Cylinder, Plane, Primitive, Sphere
from fitting.refine import linearize

LARGEST_TURN = 0.11
"""By what angle [rad] the normals of what passes for a plane may turn over its length ..."""
LARGEST_HALF_ANGLE = 0.05
LARGEST_TAPER = 0.05
LARGEST_BEND = 0.25
"""... the sides of what passes for a cylinder may lean, unless that changes its radius by less than this
share of it, and its axis may turn over its length."""
LARGEST_HOLE = 0.15
LARGEST_DIFFERENCE = 1.0
"""A sphere may be a torus with this major radius, in minor ones, and a cap may have principal curvatures that
differ by this many times their mean. What goes beyond one of these differs in practice ..."""
LEAST_BLUR = 1.5e-3
"""... where the surfaces at the two ends of an interval are at least this share of the extent apart."""

STANDARD_ERRORS = 2.0
"""Half the width of a 95 % interval."""
SIGNIFICANT = 4.0
LEAST_ESTIMATE = 0.2
"""Standard errors, and share of what differs in practice, from which a nesting parameter speaks for the more
general kind."""

CAP = 0.6
"""Length of the mean of a sphere's normals from which the cloud is a cap, with one tangent plane."""

UNDETERMINED = 1e-9
"""Share of its variance that a function must have beside the parameters of the simpler kind."""

SHORTEST = 1e-9
"""Lengths, in the normalised frame, below which nothing is divided by them."""


@dataclass(frozen=True)
class Nesting:
    """How a kind is nested in a more general one.

    Attributes
    ----------
    kind : the more general one
    columns : (N, m) what a unit of each nesting parameter moves the surface by at the points
    limit : length of the parameters beyond which the surfaces differ in practice
    asked : (m, k) combinations of them that an interval is asked of; all by default
    """

    kind: str
    columns: Array
    limit: float
    asked: Array | None = None


@dataclass(frozen=True)
class Interval:
    """Length of a kind's nesting parameters, in units of what differs in practice.

    Attributes
    ----------
    estimate, error : of those that are asked, with the standard error
    blur : standard error of the surface where the parameter moves it, as a share of the extent
    whole : estimate of all of them
    evidence : their share of the sum of squares over what noise takes of it on the average, (F m)^(1/2) in
        the notation of the F test
    """

    estimate: float
    error: float
    blur: float
    whole: float
    evidence: float

    @property
    def is_open(self) -> bool:
        """Whether a surface that differs in practice is not excluded."""
        far = self.estimate + STANDARD_ERRORS * self.error > 1.0
        return far and STANDARD_ERRORS * self.blur > LEAST_BLUR

    def is_significant(self, alike: float) -> bool:
        """Whether the points speak for the kind, `alike` of them sharing a piece of information."""
        return self.whole > LEAST_ESTIMATE and self.evidence > SIGNIFICANT * float(np.sqrt(alike))


def intervals(
    primitive: Primitive, points: Array, distance: Array, noise_scale: float, extent: float
) -> dict[str, list[Interval]]:
    """By more general kinds, one for each way in which the kind is nested in them.

    Parameters
    ----------
    primitive : the fitted one, in a frame centred near the points
    points, distance : (N, 3), (N,) those that are not outliers
    noise_scale : standard deviation of a distance; the noise counts as independent
    extent : of the cloud
    """
    found: dict[str, list[Interval]] = {}
    if primitive.kind not in NESTINGS:
        return found
    feet = points - distance[:, None] * primitive.gradient(points)
    tangent = np.linalg.qr(linearize(primitive, feet)[1])[0]
    for nesting in NESTINGS[primitive.kind](primitive, feet):
        interval = _interval(nesting, tangent, distance, noise_scale, extent)
        found.setdefault(nesting.kind, []).append(interval)
    return found


def _interval(
    nesting: Nesting, tangent: Array, distance: Array, noise_scale: float, extent: float
) -> Interval:
    n, columns = len(distance), nesting.columns * nesting.limit
    beside = columns - tangent @ (tangent.T @ columns)
    asked = beside if nesting.asked is None else beside @ nesting.asked
    estimate, error, _ = _estimate(asked, columns, distance)
    whole, _, explained = _estimate(beside, columns, distance)
    left = (float(distance @ distance) - explained) / max(n - tangent.shape[1] - columns.shape[1], 1)
    return Interval(
        estimate,
        noise_scale * error,
        noise_scale / np.sqrt(n) / extent,
        whole,
        float(np.sqrt(explained / max(left, TINY))),
    )


def _estimate(beside: Array, columns: Array, distance: Array) -> tuple[float, float, float]:
    """Length of the least squares estimate, its largest standard error, and the squares it explains."""
    sizes, vectors = np.linalg.eigh(beside.T @ beside)
    if sizes[0] <= UNDETERMINED * float(np.sum(columns**2)):
        return 0.0, np.inf, 0.0
    along = vectors.T @ (beside.T @ distance)
    explained = float(np.sum(along**2 / sizes))
    return float(np.linalg.norm(along / sizes)), float(1.0 / np.sqrt(sizes[0])), explained


def _of_plane(plane: Plane, feet: Array) -> list[Nesting]:
    """Curvature, in angles of turning over the length. What is open for a sphere is open for a cylinder."""
    x, y = _principal(feet, plane.normal)
    dome = (x**2 + y**2)[:, None] / (2.0 * max(float(np.ptp(x)), SHORTEST))
    return [Nesting(kind, dome, LARGEST_TURN) for kind in ("sphere", "cylinder")]


def _of_cylinder(cylinder: Cylinder, feet: Array) -> list[Nesting]:
    """An angle of its sides; a bend of its axis, in angles over its length, asked where it is seen best."""
    radial, rho, height = around_axis(feet, cylinder.point, cylinder.axis)
    height = height - height.mean()
    length = max(float(np.ptp(height)), SHORTEST)
    lean = max(LARGEST_HALF_ANGLE, LARGEST_TAPER * cylinder.radius / length)
    around = radial @ np.stack(basis(cylinder.axis), axis=1) / (rho + TINY)[:, None]
    bends = (height**2 / (2.0 * length))[:, None] * around
    best_seen = np.linalg.eigh(bends.T @ bends)[1][:, 1:]
    return [Nesting("cone", height[:, None], lean), Nesting("torus", bends, LARGEST_BEND, best_seen)]


def _of_sphere(sphere: Sphere, feet: Array) -> list[Nesting]:
    """A hole about any axis: R moves the surface by R times the sine of the angle from the axis.

    On a cap, too, principal curvatures that differ: those of a cylinder do by twice their mean.
    """
    outward = (feet - sphere.center) / sphere.radius
    axes = DIRECTION_GRID @ principal(feet)[1].T
    sines = sphere.radius * np.sqrt(np.maximum(1.0 - (outward @ axes.T) ** 2, 0.0))
    holes = [Nesting("torus", sine[:, None], LARGEST_HOLE) for sine in sines.T]
    middle = outward.mean(axis=0)
    if np.linalg.norm(middle) < CAP:
        return holes
    x, y = _principal(outward, middle / np.linalg.norm(middle))
    saddle = sphere.radius / 4.0 * np.stack([x**2 - y**2, 2.0 * x * y], axis=1)
    return [*holes, Nesting("cylinder", saddle, LARGEST_DIFFERENCE)]


def _principal(points: Array, normal: Array) -> Array:
    """Coordinates (2, N) across the normal: where the points are widest, and where they are narrowest."""
    across = np.stack(basis(normal), axis=1)
    flat = (points - points.mean(axis=0)) @ across
    _, axes = np.linalg.eigh(flat.T @ flat)
    return (flat @ axes[:, ::-1]).T


NESTINGS: dict[str, Callable[..., list[Nesting]]] = {
    "plane": _of_plane,
    "cylinder": _of_cylinder,
    "sphere": _of_sphere,
}
