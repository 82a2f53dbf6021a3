"""What a fitted surface leaves over of a cloud: exact points, noise, outliers, fields; how likely that is."""

import math
import sys
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from ..cloud.cloud import Cloud
from ..cloud.normals import NEIGHBOURS, local_planes
from ..cloud.patches import GRAIN, PATCHES, Halved, strips_of
from ..fields.fields import Explanations, Patched, explanations
from ..geometry.vectors import TINY, Array
from ..noise.exact import exact_points
from ..noise.outliers import NoiseModel
from ..noise.rounding import ROUNDING_NOISE
from ..primitives import is_length
from ..primitives.primitive import Primitive
from ..solver.refine import CODES, distances
from ..trial.limits import Limits, moved
from ..trial.trial import Trial
from . import _evidence

OUTLIER = 4.0
"""Points farther than this many noise scales are rejected as outliers: of normal noise 1 in 16,000."""

OUTLIERS = 0.05
"""Share of a cloud that is outliers, before anything is known of it; they are uniform over its extent."""

EXACT_REACH = 0.05
"""Beside exact points no other is an outlier up to this share of the extent: it is a deformation. Beyond,
others may be a surface of their own: nearer ones are about its edges, where neighbors are on both."""

FLAT = 0.4
"""A rejected point lies on a surface where it and its neighbors scatter about their plane by less than this
share of what they scatter in its narrower direction; of points in space 3% do."""

QUIET = 1e-4
"""Noise, over the extent, up to which points are asked whether they lie on curves."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a primitive leaves over of a cloud, in the normalized frame.

    Attributes
    ----------
    trial : kind, cloud and limits
    primitive : the surface that was judged
    free : parameters of it that no fixed value and no active limit holds
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

    trial: Trial
    primitive: Primitive
    free: int
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
    def weigh(cls, primitive: Primitive, trial: Trial) -> Self:
        """Of a primitive, in the frame of the cloud, that was fitted to it within the limits of the trial."""
        cloud, row = trial.cloud, primitive.row()
        free = primitive.dof - trial.held(row)
        distance = distances(primitive, cloud.working)
        absolute = np.abs(distance)
        exact = exact_points(absolute, cloud.tolerance, trial.dof)
        any_exact, all_exact = bool(exact.any()), bool(exact.all())
        rest = absolute[~exact] if any_exact and not all_exact else absolute
        noise = NoiseModel.of(rest, _least(cloud), cloud.extent)
        noise_scale, reach = _scatter(trial, free, absolute, exact, noise.scale)
        inlier = absolute <= reach
        explained, beside = None, 0.0
        if any_exact:
            inlier |= exact
        else:
            explained, beside = _explained(primitive, trial, inlier), _outliers(inlier, cloud)
        if explained is not None:
            beside += _sizes(primitive, row, None if trial.limits else explained.spread, cloud.extent)
        return cls(
            trial=trial,
            primitive=primitive,
            free=free,
            distance=distance,
            exact=exact,
            inlier=inlier,
            reach=reach,
            noise=noise,
            noise_scale=noise_scale,
            second_surface=0.0 if reach == np.inf else _second_surface(cloud, absolute, exact, inlier),
            explained=explained,
            beside=beside,
            on_curves=_on_curves(primitive, cloud, exact if any_exact else inlier, noise_scale),
        )

    @property
    def cloud(self) -> Cloud:
        return self.trial.cloud

    @property
    def exact_share(self) -> float:
        return int(np.count_nonzero(self.exact)) / len(self.exact)

    @property
    def inlier_share(self) -> float:
        return int(np.count_nonzero(self.inlier)) / len(self.inlier)

    @property
    def mean_inlier_distance(self) -> float:
        return float(np.abs(self.distance[self.inlier]).mean())

    @cached_property
    def bent(self) -> list[tuple[tuple[str, ...], int, Explanations]]:
        """Kinds that have this one for a limit, in how many ways they leave it, and what is left over then.

        To first order, which tells near surfaces of them without a search.
        """
        points, patch, grain = _in_patches(self.cloud, self.inlier)
        residual, jacobian, feet = _linear(self.primitive, points, None)
        found = []
        for kinds, columns in self.primitive.bends(feet):
            both = np.hstack([jacobian, columns])
            both /= np.sqrt(np.einsum("ij,ij->j", both, both)) + TINY
            # Within patches only what the step leaves counts, so it is taken off before.
            step = np.linalg.lstsq(both.T @ both, both.T @ residual, rcond=None)[0]
            explained = _by_patches(self.cloud, patch, grain, residual - both @ step, both, feet)
            if explained is not None:
                found.append((kinds, columns.shape[1], explained))
        return found

    @cached_property
    def along_its_own(self) -> list[Explanations]:
        """The inliers' distances as functions of one coordinate of the surface: around it, along it.

        What depends on one of them alone, the corners of a bar or the ribs of a can, is lost in patches.
        """
        cloud, found = self.cloud, []
        residual, jacobian, feet = _linear(self.primitive, cloud.working[self.inlier], self.trial.limits)
        for place, turn in self.primitive.coordinates(feet, cloud.extent):
            grain = strips_of(place, max(PATCHES, len(place) // GRAIN))
            patched = Patched.of(strips_of(place), grain, residual, jacobian, place[:, None], turn)
            if len(patched.mean) > jacobian.shape[1]:
                found.append(explanations(patched, cloud.extent, _least(cloud)))
        return found


def _scatter(
    trial: Trial, free: int, absolute: Array, exact: np.ndarray, noise: float
) -> tuple[float, float]:
    """Standard deviation of the noise, and the distance beyond which points are outliers.

    `noise` is that of the points that are not exact. In a small cloud all count, and none is rejected.
    """
    cloud, spare = trial.cloud, max(len(absolute) - free, 1)
    if exact.all():
        return 0.0, EXACT_REACH * cloud.extent
    if trial.is_small:
        return math.sqrt(float(absolute @ absolute) / spare), math.inf
    if exact.any():
        return noise, max(OUTLIER * noise, EXACT_REACH * cloud.extent)
    noise *= math.sqrt(len(absolute) / spare)
    return noise, max(OUTLIER * noise, cloud.tolerance)


def _second_surface(cloud: Cloud, absolute: Array, exact: np.ndarray, inlier: np.ndarray) -> float:
    """Share of the points that are far from a surface, and lie on one of their own."""
    far = absolute > EXACT_REACH * cloud.extent if exact.any() else ~inlier
    there = cloud.sample[far[cloud.sample]]
    return _on_surfaces(cloud.working[there]) / len(cloud.sample) if len(there) else 0.0


def _explained(primitive: Primitive, trial: Trial, inlier: np.ndarray) -> Explanations | None:
    """Of the inliers in patches most of whose points are inliers."""
    points, patch, grain = _in_patches(trial.cloud, inlier)
    residual, jacobian, feet = _linear(primitive, points, trial.limits)
    return _by_patches(trial.cloud, patch, grain, residual, jacobian, feet)


def _in_patches(cloud: Cloud, inlier: np.ndarray) -> tuple[Array, np.ndarray, np.ndarray]:
    """Those points, (P, 3), with the numbers of their patches and grains."""
    if inlier.all():
        return cloud.working, cloud.patch, cloud.grain
    seen = _evidence.mostly(cloud.patch, inlier.view(np.uint8)).view(bool)
    return cloud.working[seen], cloud.patch[seen], cloud.grain[seen]


def _by_patches(
    cloud: Cloud, patch: np.ndarray, grain: np.ndarray, residual: Array, jacobian: Array, feet: Array
) -> Explanations | None:
    """None where there are no more patches than parameters."""
    patched = Patched.of(patch, grain, residual, jacobian, feet / cloud.extent)
    if len(patched.mean) <= jacobian.shape[1]:
        return None
    return explanations(patched, cloud.extent, _least(cloud))


def _linear(primitive: Primitive, points: Array, limits: Limits | None) -> tuple[Array, Array, Array]:
    """Distances (N,) of points (N, 3), their derivatives (N, k) by the free steps, and their feet (N, 3)."""
    code, points = CODES[primitive.kind], np.ascontiguousarray(points)
    if limits is None:
        return _evidence.linear(code, primitive.row(), points)
    row = moved(primitive, -limits.pivot).row()
    residual, jacobian, feet = _evidence.linear(code, row, points, limits.pivot)
    return residual, jacobian @ limits.free_steps(row), feet


def _least(cloud: Cloud) -> float:
    """The smallest noise that is told from none: that of the rounding, be it coarse or fine."""
    step = 0.0 if cloud.step is None else cloud.step / cloud.frame.scale
    return max(ROUNDING_NOISE * max(cloud.tolerance, step), sys.float_info.epsilon)


def _outliers(inlier: np.ndarray, cloud: Cloud) -> float:
    """Log-probability of the outliers, which come together, too: as many count as patches have room for."""
    count = min(len(inlier), PATCHES)
    outliers = count * (1.0 - int(np.count_nonzero(inlier)) / len(inlier))
    return outliers * math.log(OUTLIERS / cloud.extent) + (count - outliers) * math.log1p(-OUTLIERS)


def _sizes(primitive: Primitive, row: Array, spread: Array | None, extent: float) -> float:
    """Log-probability of radii beyond the extent over that of smaller ones.

    Who cuts a cloud into segments leaves a piece that shows what it is a piece of: the density falls as the
    share of a sphere that the piece is, with the square of the radius. A curvature that is known to no better
    than `spread`, (dof,) of the steps, may be as large as that; within limits it is as they say.
    """
    found = 0.0
    for name, (component, place) in primitive.chart.numbers.items():
        radius = float(row[place])
        if radius <= extent or not is_length(name):
            continue
        unsure = 0.0 if spread is None else float(spread[component])
        found -= 2.0 * max(0.0, math.log(radius * radius / math.hypot(radius, unsure) / extent))
    return found


def _on_curves(primitive: Primitive, cloud: Cloud, near: np.ndarray, noise_scale: float) -> bool:
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
    sizes = np.linalg.svd(terms / np.sqrt(len(terms)), compute_uv=False)
    return int(np.count_nonzero(sizes <= reach)) > primitive.quadrics


def _on_surfaces(points: Array) -> int:
    """How many of the points (N, 3) lie on a surface with their neighbors among them."""
    if len(points) < 2 * NEIGHBOURS:
        return 0
    _, scatter, breadth = local_planes(points, Halved.of(points), at=points)
    return int(np.count_nonzero(scatter < FLAT * breadth))
