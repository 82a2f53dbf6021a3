"""A checked cloud with everything about it that does not depend on the kind that is tried."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from ..errors import InvalidPointCloudError
from ..geometry import _linear
from ..geometry.vectors import Array, bounds, principal
from ..guesses.oriented import Oriented
from ..noise.rounding import FEWEST_STEPS, ROUNDING_NOISE, ULPS, float32_step, rounding_of
from . import _passes
from .frame import Frame
from .normals import local_planes
from .order import canonical_order, canonical_sample, distance_keys, shuffled
from .patches import Halved
from .weights import factors_of

WORKING_POINTS = 20_000
"""Larger clouds are searched and judged on a random sample of this size; noisy ones end on all points."""

SAMPLE_POINTS = 1024
"""Points whose residuals are compared with those of their neighbors ..."""

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
    """A cloud in its normalized frame.

    Attributes
    ----------
    frame : carries primitives back to the input
    points : (N, 3) all points
    working : (M, 3) the different points, or a random sample of them in a large cloud; all where they have
        weights
    sample : (S,) indices into `working`, in random order
    normals : (L, 3) unit normals at the first L of them
    flattest : (L // 2,) indices into `sample` of the half of them whose neighbors scatter least about local
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
        unit: str | None = None,
    ) -> Self:
        """Check, normalize, sample; raises `InvalidPointCloudError` for what cannot be a cloud.

        `unit` is the name of the unit of the points, for words.
        """
        given = _Given.checked(points, normals, weights, standard_deviations)
        keys = distance_keys(given.points, given.box)
        if len(given.points) <= WORKING_POINTS:
            order = canonical_order(given.points, keys)
            given, keys = given.taken(order), keys[order]
        checked, normals, factors = given.points, given.normals, given.factors
        frame = Frame.of(checked, given.box, unit)
        normalized = frame.normalize(checked)
        rounding = rounding_of(checked, given.box)
        tolerance = rounding.size / frame.scale
        choosing, sampling = _seeds(rng)
        chosen = _working(checked, keys, factors is not None, choosing)
        working = _rows(normalized, chosen)
        spread, axes = principal(working)
        step = float32_step(checked, given.box)
        if spread[1] <= max(FLAT * spread[0], 2.0 * tolerance, ROUNDING_NOISE * (step or 0.0) / frame.scale):
            raise InvalidPointCloudError(
                f"the {len(checked)} points are collinear (width over length {spread[1] / spread[0]:.1e}): "
                "no primitive is determined" + _remedy(step)
            )
        sample = shuffled(_rows(keys, chosen), SAMPLE_POINTS, np.random.default_rng(sampling))
        seen = sample[:NORMAL_POINTS]
        along = working @ axes
        halved = Halved.of(along)
        normals_along, scatter, _ = local_planes(along, halved, at=along[seen])
        flattest = np.argsort(scatter, kind="stable")[: (len(scatter) + 1) // 2]
        return cls(
            frame=frame,
            points=normalized,
            working=working,
            sample=sample,
            normals=normals_along @ axes.T if normals is None else normals[chosen[seen]],
            flattest=np.sort(flattest),
            local_noise=_middle(scatter[flattest]),
            tolerance=tolerance,
            step=rounding.step,
            diagonal=_diagonal(frame.normalize(given.box)),
            patch=halved.patches(),
            grain=halved.grains(),
            axes=axes,
            extent=_diagonal(bounds(along)),
            flat=bool(spread[2] <= tolerance),
            factors=factors,
            working_factors=None if factors is None else _rows(factors, chosen),
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
    box: Array
    normals: Array | None
    factors: Array | None

    @classmethod
    def checked(
        cls, points: object, normals: Array | None, weights: object, standard_deviations: object
    ) -> Self:
        """Without points of no weight; raises `InvalidPointCloudError` for what cannot be a cloud."""
        array, box = _cloud_in_box(points)
        given = cls(
            array,
            box,
            None if normals is None else check_normals(normals, len(array)),
            factors_of(weights, standard_deviations, len(array)),
        )
        if given.factors is not None and not given.factors.all():
            given = given.taken(np.flatnonzero(given.factors))
            given = replace(given, box=_cloud_in_box(given.points)[1])
        if given.factors is not None and np.all(given.factors == given.factors[0]):
            return replace(given, factors=None)
        return given

    def taken(self, rows: np.ndarray) -> Self:
        """Of these points only, in the same box."""
        normals, factors = (
            None if values is None else values.take(rows, axis=0) for values in (self.normals, self.factors)
        )
        return type(self)(self.points.take(rows, axis=0), self.box, normals, factors)


def _seeds(rng: np.random.Generator) -> list[np.random.SeedSequence]:
    """Of the generators that choose working points and sample them: one alone is mostly needed."""
    return rng.bit_generator.seed_seq.spawn(2)  # type: ignore[attr-defined]


def _working(points: Array, keys: np.ndarray, weighted: bool, seed: np.random.SeedSequence) -> np.ndarray:
    """Indices (M,) of the working points among (N, 3), which are in canonical order unless they are many."""
    if len(points) > WORKING_POINTS:
        return canonical_sample(points, keys, WORKING_POINTS, np.random.default_rng(seed), repeated=weighted)
    return np.arange(len(points)) if weighted else _passes.firsts(points)


def _rows(values: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """`values[chosen]`, or the values themselves where all are chosen, which then is in their order."""
    return values if len(chosen) == len(values) else values.take(chosen, axis=0)


def _middle(ascending: Array) -> float:
    """The median."""
    return float(ascending[(len(ascending) - 1) // 2] + ascending[len(ascending) // 2]) / 2.0


def _diagonal(box: Array) -> float:
    """Of a box, from its lowest to its highest corner."""
    return math.dist(*box.tolist())


def check_coordinates(points: object) -> Array:
    """The points as a finite float64 array of shape (N, 3), or an error."""
    return _in_box(points)[0]


def check_points(points: object) -> Array:
    """The points as a finite float64 array of shape (N, 3) that is a cloud, or an error."""
    return _cloud_in_box(points)[0]


def _in_box(points: object) -> tuple[Array, Array]:
    """As `check_coordinates`, and the box (2, 3) around them."""
    try:
        array = np.asarray(points, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise InvalidPointCloudError("points cannot be read as numbers of shape (N, 3)") from error
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidPointCloudError(f"points have shape {array.shape}; (N, 3) is needed")
    box, all_finite = _linear.bounds(array)
    if not all_finite:
        finite = np.isfinite(array).all(axis=1)
        raise InvalidPointCloudError(
            f"{int((~finite).sum())} of {len(array)} points hold NaN or infinity; "
            f"the first is points[{int(np.argmin(finite))}]"
        )
    largest = float(np.abs(box).max())
    if largest > LARGEST_COORDINATE and len(array):
        raise InvalidPointCloudError(f"a coordinate is {largest:.3g}; the limit is {LARGEST_COORDINATE:.0e}")
    return array, box


def _cloud_in_box(points: object) -> tuple[Array, Array]:
    """As `check_points`, and the box (2, 3) around them."""
    array, box = _in_box(points)
    if len(array) < 3:
        raise InvalidPointCloudError(f"{len(array)} points given; at least 3 are needed")
    extent = float(np.max(box[1] - box[0]))
    step = float32_step(array, box)
    if extent == 0.0:
        raise InvalidPointCloudError(f"all {len(array)} points are the same one{_remedy(step)}")
    if step is not None and extent < FEWEST_STEPS * step:
        raise InvalidPointCloudError(
            f"the cloud is {extent:.3g} wide, not {FEWEST_STEPS} steps of its coordinates{_remedy(step)}"
        )
    if extent < SMALLEST_EXTENT:
        raise InvalidPointCloudError(f"the cloud is {extent:.3g} in size; the limit is {SMALLEST_EXTENT:.0e}")
    return array, box


def _remedy(step: float | None) -> str:
    """What to do where float32 numbers are too coarse for a cloud, behind what is wrong with it."""
    if step is None:
        return ""
    remedy = "store float64, or subtract an offset before writing float32"
    return f"; float32 numbers so far from the origin have steps of {step:.3g}: {remedy}"


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
