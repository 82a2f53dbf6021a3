"""A checked cloud with everything about it that does not depend on the kind that is tried."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from ..errors import InvalidPointCloudError
from ..geometry.axes import Oriented
from ..geometry.vectors import Array, principal
from ..noise.rounding import ULPS, rounding_of
from .frame import Frame
from .normals import local_planes
from .order import canonical_order, canonical_sample, distance_keys, is_first, shuffled
from .patches import grains_of, patches_of
from .weights import factors_of

WORKING_POINTS = 20_000
"""Larger clouds are searched and judged on a random sample of this size; noisy ones end on all points."""

SAMPLE_POINTS = 1024
"""Points whose residuals are compared with those of their neighbours ..."""

NORMAL_POINTS = 512
"""... and those of them that get normals: the classifier sees these, starts are derived from the first."""

SEARCH_POINTS = 512
"""Points that the annealing runs on."""

GUESS_POINTS = 160
"""The first of them: starts are derived from these and ranked on them."""

LARGEST_COORDINATE = 1e100
"""Beyond this magnitude squares and products of coordinates overflow."""

SMALLEST_EXTENT = 1e-100
"""Below this size of the bounding box they underflow."""

FLAT = 1e-10
"""Second singular value over the first below which points count as collinear, beyond their rounding."""


@dataclass(frozen=True)
class Cloud:
    """A cloud in its normalised frame.

    Attributes
    ----------
    frame : carries primitives back to the input
    points : (N, 3) all points
    working : (M, 3) the different points, or a random sample of them in a large cloud; all where they have
        weights
    sample : (S,) indices into `working`, in random order
    normals : (L, 3) unit normals at the first L of them
    flattest : (L // 2,) indices into `sample` of the half of them whose neighbours scatter least about local
        planes: few outliers are among them
    local_noise : median of that scatter among those
    tolerance : size of the rounding of the coordinates
    step : of the decimal coordinates, in input units, or None
    diagonal : of the bounding box
    patch, grain : (M,) number of the patch, and of the grain, that each working point is in
    axes : (3, 3) principal axes of the working points, the widest first, in columns
    extent : diagonal of the box along them around the working points, which turns with the cloud
    flat : all points lie in one plane within the rounding
    factors : (N,) what the distances of `points` are multiplied by in the last refinement, or None
    working_factors : (M,) the same for `working`
    """

    frame: Frame
    points: Array
    working: Array
    sample: np.ndarray
    normals: Array
    flattest: np.ndarray
    local_noise: float
    tolerance: float
    step: float | None
    diagonal: float
    patch: np.ndarray
    grain: np.ndarray
    axes: Array
    extent: float
    flat: bool
    factors: Array | None = None
    working_factors: Array | None = None

    @cached_property
    def searched(self) -> Array:
        """(K, 3) the points that a search looks at."""
        return self.working[self.sample[:SEARCH_POINTS]]

    @cached_property
    def oriented(self) -> Oriented:
        """The first of them with their normals."""
        return Oriented(self.searched[:GUESS_POINTS], self.normals[:GUESS_POINTS])

    @classmethod
    def prepare(
        cls,
        points: object,
        normals: Array | None,
        rng: np.random.Generator,
        weights: object = None,
        standard_deviations: object = None,
    ) -> Self:
        """Check, normalise, sample; raises `InvalidPointCloudError` for what cannot be a cloud."""
        given = _Given.checked(points, normals, weights, standard_deviations)
        keys = distance_keys(given.points)
        if len(given.points) <= WORKING_POINTS:
            order = canonical_order(given.points, keys)
            given, keys = given.taken(order), keys[order]
        checked, normals, factors = given.points, given.normals, given.factors
        frame = Frame.of(checked)
        normalized = frame.normalize(checked)
        rounding = rounding_of(checked)
        tolerance = rounding.size / frame.scale
        choosing, sampling = rng.spawn(2)
        chosen = _working(checked, keys, factors is not None, choosing)
        working = normalized[chosen]
        spread, axes = principal(working)
        if spread[1] <= max(FLAT * spread[0], 2.0 * tolerance):
            raise InvalidPointCloudError(
                f"the {len(checked)} points are collinear (width over length {spread[1] / spread[0]:.1e}): "
                "no primitive is determined"
            )
        sample = shuffled(keys[chosen], sampling)[:SAMPLE_POINTS]
        seen = sample[:NORMAL_POINTS]
        normals_there, scatter = local_planes(working, at=working[seen])
        flattest = np.sort(np.argsort(scatter, kind="stable")[: (len(scatter) + 1) // 2])
        return cls(
            frame=frame,
            points=normalized,
            working=working,
            sample=sample,
            normals=normals_there if normals is None else normals[chosen[seen]],
            flattest=flattest,
            local_noise=float(np.median(scatter[flattest])),
            tolerance=tolerance,
            step=rounding.step,
            diagonal=float(np.linalg.norm(np.ptp(normalized, axis=0))),
            patch=patches_of(working @ axes),
            grain=grains_of(working @ axes),
            axes=axes,
            extent=float(np.linalg.norm(np.ptp(working @ axes, axis=0))),
            flat=bool(spread[2] <= tolerance),
            factors=factors,
            working_factors=None if factors is None else factors[chosen],
        )

    def about(self, origin: Array) -> Self:
        """The same cloud with its points relative to another origin, which may round them more coarsely."""
        rounding = ULPS * float(np.finfo(np.float64).eps) * float(np.max(np.abs(origin)))
        return replace(
            self,
            points=self.points - origin,
            working=self.working - origin,
            tolerance=max(self.tolerance, rounding),
        )


@dataclass(frozen=True, eq=False)
class _Given:
    """What a caller gives of each point."""

    points: Array
    normals: Array | None
    factors: Array | None

    @classmethod
    def checked(
        cls, points: object, normals: Array | None, weights: object, standard_deviations: object
    ) -> Self:
        """Without points of no weight; raises `InvalidPointCloudError` for what cannot be a cloud."""
        array = check_points(points)
        given = cls(
            array,
            None if normals is None else check_normals(normals, len(array)),
            factors_of(weights, standard_deviations, len(array)),
        )
        if given.factors is not None and not given.factors.all():
            given = given.taken(given.factors > 0.0)
            check_points(given.points)
        if given.factors is not None and np.all(given.factors == given.factors[0]):
            return replace(given, factors=None)
        return given

    def taken(self, rows: np.ndarray) -> Self:
        """Of these points only."""
        each = (self.points, self.normals, self.factors)
        return type(self)(*(None if values is None else values[rows] for values in each))  # type: ignore[arg-type]


def _working(points: Array, keys: np.ndarray, weighted: bool, rng: np.random.Generator) -> np.ndarray:
    """Indices (M,) of the working points among (N, 3), which are in canonical order unless they are many."""
    if len(points) > WORKING_POINTS:
        return canonical_sample(points, keys, WORKING_POINTS, rng, repeated=weighted)
    return np.arange(len(points)) if weighted else np.flatnonzero(is_first(points))


def check_coordinates(points: object) -> Array:
    """The points as a finite float64 array of shape (N, 3), or an error."""
    try:
        array = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidPointCloudError("points cannot be read as numbers of shape (N, 3)") from error
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidPointCloudError(f"points have shape {array.shape}; (N, 3) is needed")
    finite = np.isfinite(array).all(axis=1)
    if not finite.all():
        raise InvalidPointCloudError(
            f"{int((~finite).sum())} of {len(array)} points hold NaN or infinity; "
            f"the first is points[{int(np.argmin(finite))}]"
        )
    largest = float(np.max(np.abs(array), initial=0.0))
    if largest > LARGEST_COORDINATE:
        raise InvalidPointCloudError(f"a coordinate is {largest:.3g}; the limit is {LARGEST_COORDINATE:.0e}")
    return array


def check_points(points: object) -> Array:
    """The points as a finite float64 array of shape (N, 3) that is a cloud, or an error."""
    array = check_coordinates(points)
    if len(array) < 3:
        raise InvalidPointCloudError(f"{len(array)} points given; at least 3 are needed")
    if np.all(array == array[0]):
        raise InvalidPointCloudError(f"all {len(array)} points are the same one")
    extent = float(np.max(np.ptp(array, axis=0)))
    if extent < SMALLEST_EXTENT:
        raise InvalidPointCloudError(f"the cloud is {extent:.3g} in size; the limit is {SMALLEST_EXTENT:.0e}")
    return array


def check_normals(normals: object, n_points: int) -> Array:
    """Unit normals of shape (N, 3), one a point, or an error."""
    try:
        array = np.asarray(normals, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidPointCloudError(
            "normals cannot be read as numbers of shape (N, 3)", "normals"
        ) from error
    if array.shape != (n_points, 3):
        raise InvalidPointCloudError(
            f"normals have shape {array.shape}; ({n_points}, 3) is needed", "normals"
        )
    length = np.linalg.norm(array, axis=1)
    if not np.all(np.isfinite(length) & (length > 0.0)):
        row = int(np.argmin(np.isfinite(length) & (length > 0.0)))
        raise InvalidPointCloudError(f"normals[{row}] is zero or not finite", "normals")
    return array / length[:, None]
