"""What a fitted surface leaves over of a cloud: exact points, noise, outliers, fields; how likely that is."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.spatial import cKDTree

from ..cloud.cloud import Cloud
from ..cloud.normals import NEIGHBOURS
from ..cloud.patches import GRAIN, PATCHES, strips_of
from ..geometry.vectors import Array, around_axis, basis, principal
from ..noise.exact import exact_points
from ..noise.fields import Explanations, Patched, explanations
from ..noise.outliers import NoiseModel
from ..noise.rounding import ROUNDING_NOISE
from ..primitives import Primitive
from ..primitives.cone import Cone
from ..primitives.cylinder import Cylinder
from ..primitives.plane import Plane
from ..primitives.sphere import Sphere
from ..primitives.torus import Torus
from ..solver.limits import NUMBERS, Limits, dof_within, moved
from ..solver.refine import linearize

OUTLIER = 4.0
"""Points farther than this many noise scales are rejected as outliers: of normal noise 1 in 16,000."""

OUTLIERS = 0.05
"""Share of a cloud that is outliers, before anything is known of it; they are uniform over its extent."""

EXACT_REACH = 0.05
"""Beside exact points no other is an outlier up to this share of the extent: it is a deformation. Beyond,
others may be a surface of their own: nearer ones are about its edges, where neighbours are on both."""

FLAT = 0.4
"""A rejected point lies on a surface where it and its neighbours scatter about their plane by less than this
share of what they scatter in its narrower direction; of points in space 3 % do."""

QUIET = 1e-4
"""Noise, over the extent, up to which points are asked whether they lie on curves."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a primitive leaves over of a cloud, in the normalised frame.

    Attributes
    ----------
    primitive : the surface that was judged
    limits : within which it was fitted
    free : parameters of it that no fixed value and no active limit holds
    small : too few points to reject any
    distance : (M,) signed distances of the working points
    exact : (M,) mask of the points on the surface within the rounding
    inlier : (M,) mask of the points not rejected as outliers
    reach : distance beyond which they are, infinite in small clouds, where none is
    noise : the mixture of noise and outliers that makes the distances of the others most likely
    noise_scale : standard deviation of the noise; of small clouds, in which none is an outlier, of all points
    second_surface : share of the points that are far from it and lie on a surface of their own
    explained : the inliers' distances as white noise and fields; None beside exact points, and where points
        are too few
    beside : logarithm of the probability of the outliers and of the sizes of the primitive
    on_curves : the points lie on curves, such as two rings, through which other surfaces pass as well
    """

    primitive: Primitive
    limits: Limits | None
    free: int
    small: bool
    distance: Array
    exact: np.ndarray
    inlier: np.ndarray
    reach: float
    noise: NoiseModel
    noise_scale: float
    second_surface: float
    explained: Explanations | None
    beside: float
    on_curves: bool

    @classmethod
    def weigh(cls, primitive: Primitive, cloud: Cloud, limits: Limits | None = None) -> Self:
        """Of a primitive, in the frame of the cloud, that was fitted to it within limits."""
        dof = dof_within(primitive.kind, limits)
        free = primitive.dof - (0 if limits is None else limits.held(primitive.row()))
        small = cloud.is_small(dof)
        distance = primitive.signed_distance(cloud.working)
        absolute = np.abs(distance)
        exact = exact_points(absolute, cloud.tolerance, dof)
        rest = distance if exact.all() else distance[~exact]
        noise = NoiseModel.of(rest, ROUNDING_NOISE * cloud.tolerance, cloud.extent)
        inlier, reach, second = np.ones_like(exact), np.inf, 0.0
        spare = max(len(absolute) - free, 1)
        if exact.all():
            noise_scale, reach = 0.0, EXACT_REACH * cloud.extent
        elif small:
            noise_scale = float(np.sqrt(np.sum(absolute**2) / spare))
        else:
            noise_scale = noise.scale
            if not exact.any():
                noise_scale *= float(np.sqrt(len(absolute) / spare))
            nearby = EXACT_REACH * cloud.extent if exact.any() else cloud.tolerance
            reach = max(OUTLIER * noise_scale, nearby)
            inlier = exact | (absolute <= reach)
            far = absolute > nearby if exact.any() else ~inlier
            second = _on_surfaces(cloud.working[cloud.sample[far[cloud.sample]]]) / len(cloud.sample)
        explained, beside = None, 0.0
        if not exact.any():
            explained, beside = _explained(primitive, cloud, inlier, limits), _outliers(inlier, cloud)
        if explained is not None:
            spread = explained.spread if limits is None else np.zeros(primitive.dof)
            beside += _sizes(primitive, spread, cloud.extent)
        return cls(
            primitive,
            limits,
            free,
            small,
            distance,
            exact,
            inlier,
            reach,
            noise,
            noise_scale,
            second,
            explained,
            beside,
            _on_curves(primitive.kind, cloud, exact if exact.any() else inlier, noise_scale),
        )

    @property
    def exact_share(self) -> float:
        return float(self.exact.mean())

    @property
    def inlier_share(self) -> float:
        return float(self.inlier.mean())

    @property
    def mean_inlier_distance(self) -> float:
        return float(np.abs(self.distance[self.inlier]).mean())

    def along_its_own(self, cloud: Cloud) -> list[Explanations]:
        """The inliers' distances as functions of one coordinate of the surface: around it, along it.

        What depends on one of them alone, the corners of a bar or the ribs of a can, is lost in patches.
        """
        residual, jacobian, feet = _linear(self.primitive, cloud.working[self.inlier], self.limits)
        found = []
        for place, turn in _coordinates(self.primitive, feet, cloud.extent):
            grain = strips_of(place, max(PATCHES, len(place) // GRAIN))
            patched = Patched.of(strips_of(place), grain, residual, jacobian, place[:, None], turn)
            if len(patched.mean) > jacobian.shape[1]:
                found.append(explanations(patched, cloud.extent, _least(cloud)))
        return found


def _explained(
    primitive: Primitive, cloud: Cloud, inlier: np.ndarray, limits: Limits | None
) -> Explanations | None:
    """Of the inliers in patches most of whose points are inliers."""
    most = np.bincount(cloud.patch, inlier) >= 0.5 * np.bincount(cloud.patch)
    seen = inlier & most[cloud.patch]
    residual, jacobian, feet = _linear(primitive, cloud.working[seen], limits)
    patched = Patched.of(cloud.patch[seen], cloud.grain[seen], residual, jacobian, feet / cloud.extent)
    if len(patched.mean) <= jacobian.shape[1]:
        return None
    return explanations(patched, cloud.extent, _least(cloud))


def _linear(primitive: Primitive, points: Array, limits: Limits | None) -> tuple[Array, Array, Array]:
    """Distances (N,) of points (N, 3), their derivatives (N, k) by the free steps, and their feet."""
    if limits is None:
        residual, jacobian = linearize(primitive, points)
    else:
        residual, jacobian = linearize(moved(primitive, -limits.pivot), points - limits.pivot)
        jacobian = jacobian @ limits.free_steps(moved(primitive, -limits.pivot).row(), primitive.dof)
    return residual, jacobian, points - residual[:, None] * primitive.gradient(points)


def _least(cloud: Cloud) -> float:
    """The smallest noise that is told from none."""
    return max(ROUNDING_NOISE * cloud.tolerance, float(np.finfo(np.float64).eps))


def _outliers(inlier: np.ndarray, cloud: Cloud) -> float:
    """Log-probability of the outliers, which come together, too: as many count as patches have room for."""
    count = min(len(inlier), PATCHES)
    outliers = count * float(1.0 - inlier.mean())
    return outliers * float(np.log(OUTLIERS / cloud.extent)) + (count - outliers) * float(np.log1p(-OUTLIERS))


def _sizes(primitive: Primitive, spread: Array, extent: float) -> float:
    """Log-probability of radii beyond the extent over that of smaller ones.

    Who cuts a cloud into segments leaves a piece that shows what it is a piece of: the density falls as the
    share of a sphere that the piece is, with the square of the radius. A curvature that is known to no better
    than `spread`, (dof,) of the steps, may be as large as that.
    """
    found = 0.0
    for (kind, name), (component, place) in NUMBERS.items():
        if kind != primitive.kind or name == "half_angle":
            continue
        radius = float(primitive.row()[place])
        if radius > 0.0:
            likely = radius * radius / float(np.hypot(radius, spread[component]))
            found -= 2.0 * max(0.0, float(np.log(likely / extent)))
    return found


def _coordinates(primitive: Primitive, feet: Array, extent: float) -> list[tuple[Array, float]]:
    """Coordinates (N,) on a surface, angles [rad] and lengths over the extent, with their period or 0."""
    if isinstance(primitive, Sphere):
        return []
    if isinstance(primitive, Plane):
        axes = principal(feet)[1]
        return [(feet @ axes[:, 0] / extent, 0.0), (feet @ axes[:, 1] / extent, 0.0)]
    origin = {Cylinder: "point", Cone: "apex", Torus: "center"}[type(primitive)]
    axis: Array = primitive.axis  # type: ignore[attr-defined]
    radial, rho, height = around_axis(feet, getattr(primitive, origin), axis)
    u, v = basis(axis)
    around = np.arctan2(radial @ v, radial @ u), 2.0 * np.pi
    if isinstance(primitive, Torus):
        return [around, (np.arctan2(height, rho - primitive.major_radius), 2.0 * np.pi)]
    return [around, (height / extent, 0.0)]


def _on_curves(kind: str, cloud: Cloud, near: np.ndarray, noise_scale: float) -> bool:
    """Whether more quadrics than hold all of a surface of this kind pass through its points as exactly.

    Two of them meet in curves. Within much noise every arc has several. A plane is held by itself times any
    linear term, a torus by none.
    """
    reach = max(noise_scale, cloud.tolerance) / cloud.extent
    if reach > QUIET:
        return False
    x, y, z = (cloud.working[cloud.sample[near[cloud.sample]]] @ cloud.axes / cloud.extent).T
    linear, square = [np.ones_like(x), x, y, z], [x * x, y * y, z * z, x * y, x * z, y * z]
    terms = np.stack(linear + square, axis=1)
    own = {"plane": len(linear), "torus": 0}.get(kind, 1)
    sizes = np.linalg.svd(terms / np.sqrt(len(terms)), compute_uv=False)
    return int(np.count_nonzero(sizes <= reach)) > own


def _on_surfaces(points: Array) -> int:
    """How many of the points (N, 3) lie on a surface with their neighbours among them."""
    if len(points) < 2 * NEIGHBOURS:
        return 0
    offsets = points[cKDTree(points).query(points, k=NEIGHBOURS)[1]]
    offsets -= offsets.mean(axis=1, keepdims=True)
    squares = np.linalg.eigvalsh(np.einsum("nki,nkj->nij", offsets, offsets))
    return int(np.count_nonzero(squares[:, 0] < FLAT**2 * squares[:, 1]))
