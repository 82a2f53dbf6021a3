"""Residuals of a surface as white noise and random fields on it: how likely, and how large is each part?

Noise of sensors is shared by neighbours, and over the whole cloud it is as large as what differs between
neighbouring kinds; parts bow and bulge by as much. So residuals count as

    r = J s + e + f + g

with steps s of the parameters, white noise e, a rough field f of correlation exp(-d / l), and a smooth one g
of exp(-d^2 / 2 l^2), where d is the distance between feet on the surface. Points are taken together in
patches (their means, and what they scatter about those), so that all of them count where the fields are
small, and no more than some dozen where they are not.
Source: Rasmussen and Williams, "Gaussian processes for machine learning", 2006, chapters 2 and 5; Occam's
factor: MacKay, "Information theory, inference, and learning algorithms", 2003, chapter 28; exponential
variograms: Cressie, "Statistics for spatial data", 1993, section 2.3.
"""

from dataclasses import dataclass
from functools import cache
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ..geometry.vectors import TINY, Array
from . import _noise

RATIO = float(np.sqrt(10.0))
"""Sizes and ranges of the fields are looked at so many times as large as each other: half a decade."""

ROUGH = (1 / RATIO, 1.0, RATIO)
"""Standard deviations of the rough field, over that of the white noise: from what is hardly seen in a patch
to nearly all of the noise."""

ROUGH_RANGES = (1 / RATIO**2, 1 / RATIO, 1.0)
"""Its ranges, over the extent: from a patch to the whole cloud."""

SMOOTH = (1.0, RATIO, RATIO**2, RATIO * RATIO**2)
"""Standard deviations of the smooth field, over that of the white noise: from one that patches just show to
that of a wrong kind under little noise."""

SMOOTH_RANGES = (0.5 / RATIO, 1.0)
"""Its ranges, over the extent: of waves, which patches just show, and of a bow of all of it."""

EPS = float(np.finfo(np.float64).eps)
"""Directions that move the surface by less than this, over the one that moves it most, are not seen."""

PRIOR = 0.5
"""Extents by which a parameter may move the surface: to either side as far as the cloud goes."""


@dataclass(frozen=True, eq=False)
class Patched:
    """Residuals of a surface, patch by patch.

    Attributes
    ----------
    mean : (P,) of the residuals of each patch
    jacobian : (P, dof) of their derivatives
    count : (P,) how many points it has
    apart : (P, P) distances between the patches, over the extent
    scatter : standard deviation of the residuals within the smaller pieces, 0 where none has two points
    spare : how many such deviations are free, at most P: in a patch points tell the same
    hidden : standard deviation within patches beyond that
    """

    mean: Array
    jacobian: Array
    count: Array
    apart: Array
    scatter: float
    spare: float
    hidden: float

    @classmethod
    def of(
        cls,
        patch: np.ndarray,
        grain: np.ndarray,
        residual: Array,
        jacobian: Array,
        place: Array,
        turn: float = 0.0,
    ) -> Self:
        """Of points with the numbers (N,) of their patches and of smaller pieces.

        They are at `place` (N, k), over the extent. With a `turn`, places that differ by it are the same.
        """
        count, means, _ = _means(patch, np.column_stack([residual, jacobian, place]))
        dof = jacobian.shape[1]
        between = means[:, None, 1 + dof :] - means[None, :, 1 + dof :]
        if turn:
            between = np.minimum(np.abs(between), turn - np.abs(between))
        within, count_within = _scatter(patch, residual)
        scatter, count_scatter = _scatter(grain, residual)
        return cls(
            means[:, 0],
            means[:, 1 : 1 + dof],
            count,
            np.sqrt(np.sum(between**2, axis=2)),
            scatter,
            float(min(count_scatter, len(count))),
            float(np.sqrt(max(within**2 - scatter**2, 0.0))) if count_within else 0.0,
        )


def _scatter(number: np.ndarray, residual: Array) -> tuple[float, int]:
    """Standard deviation of residuals (N,) about the means of equal numbers, and how many are free."""
    count, means, place = _means(number, residual[:, None])
    free = len(residual) - len(count)
    squares = float(np.sum((residual - means[place, 0]) ** 2))
    return (float(np.sqrt(squares / free)) if free else 0.0), free


def _means(number: np.ndarray, columns: Array) -> tuple[Array, Array, np.ndarray]:
    """Of the rows (N, k) with the same number: how many, their means, and which of these is each row's."""
    count = np.bincount(number).astype(np.float64)
    found = count > 0.0
    sums = np.stack([np.bincount(number, column) for column in columns.T], axis=1)
    return count[found], sums[found] / count[found, None], (np.cumsum(found) - 1)[number]


@dataclass(frozen=True, eq=False)
class Explanations:
    """Ways to explain residuals: a size and range of either field each.

    Attributes
    ----------
    log_evidence : (T,) of the residuals under each
    white : (T,) standard deviation of the white noise of a point
    rough, rough_range : (T,) of the rough field, as it shows beside what steps of the parameters take of it;
        the range over the extent
    smooth, smooth_range : (T,) the same of the smooth one
    rough_size, smooth_size : (T,) standard deviations of the fields themselves, over the white noise
    apart : logarithm of the evidence if the means of patches have a white noise of their own, -inf where no
        patch has two points
    apart_white : standard deviation of a point that this noise amounts to
    hidden : deviation within patches, which the fields do not see
    spread : (dof,) standard deviations of the parameters under the likeliest
    unexplained : logarithm of how much likelier the residuals would be if they were white noise as points
        have it within patches, None where no patch has two points
    """

    log_evidence: Array
    white: Array
    rough: Array
    rough_range: Array
    smooth: Array
    smooth_range: Array
    rough_size: Array
    smooth_size: Array
    apart: float
    apart_white: float
    hidden: float
    spread: Array
    unexplained: float | None

    @property
    def likeliest(self) -> int:
        return int(np.argmax(self.log_evidence))

    def among(self, chosen: np.ndarray) -> float:
        """Evidence of the chosen (T,) ones together, each as likely beforehand; none has none."""
        return log_mean(self.log_evidence[chosen])


def log_mean(logarithms: Array) -> float:
    """Logarithm of the mean of what these are logarithms of."""
    if not len(logarithms):
        return -np.inf
    highest = logarithms.max()
    return float(highest + np.log(np.mean(np.exp(logarithms - highest))))


def explanations(patched: Patched, extent: float, least: float) -> Explanations:
    """Of residuals with fewer parameters than patches; `least` is the smallest noise of a point.

    For each pair of fields the white noise is the most likely one, the parameters take one step of
    generalised least squares, and Occam's factor is that of a normal prior by which each of them, turned so
    that it moves the surface by itself, may move it by `PRIOR` extents in the mean square. Two fields are
    looked at together where each alone explains more than white noise; else they explain nothing.
    """
    directions = _whitening(patched.jacobian)
    whitened = patched.jacobian @ directions
    bells, (single, paired, both) = _bells(patched.apart), _grid()
    alone = _weighed(single, bells, patched, whitened, extent, least)
    helps = alone.log_evidence > alone.log_evidence[0]
    useful = helps[paired].all(axis=1)
    pairs = _weighed(both.among(useful), bells, patched, whitened, extent, least)
    best = pairs if useful.any() and pairs.highest > alone.highest else alone
    white, shape = best.white[best.likeliest], best.shape[best.likeliest]
    spread = white * np.sqrt(np.einsum("ij,jk,ik->i", directions, shape, directions))
    useless = np.zeros(np.count_nonzero(~useful))

    def column(name: str, rest: Array) -> Array:
        return np.concatenate([getattr(alone, name), getattr(pairs, name), rest])

    evidence = column("log_evidence", useless - np.inf)
    return Explanations(
        evidence,
        column("white", useless + white),
        column("rough", useless),
        column("rough_range", useless),
        column("smooth", useless),
        column("smooth_range", useless),
        column("rough_size", useless),
        column("smooth_size", useless),
        *_apart(patched, whitened, extent, least),
        patched.hidden,
        spread,
        _unexplained(patched, whitened.shape[1], log_mean(evidence), extent),
    )


@dataclass(frozen=True, eq=False)
class _Fields:
    """T pairs of a rough and a smooth field: sizes (T, 2) over the white noise, and numbers of bells."""

    size: Array
    bell: NDArray[np.int64]

    def among(self, chosen: np.ndarray) -> Self:
        return type(self)(self.size[chosen], self.bell[chosen])

    @property
    def range(self) -> Array:
        """Ranges (T, 2) over the extent, 0 where there is no field."""
        return np.where(self.size > 0.0, np.array(ROUGH_RANGES + SMOOTH_RANGES)[self.bell], 0.0)


@cache
def _grid() -> tuple[_Fields, NDArray[np.intp], _Fields]:
    """Fields by themselves, none of them first; the numbers (72, 2) of those that are paired; the pairs."""
    rough = [((size, 0.0), (bell, 0)) for bell in range(len(ROUGH_RANGES)) for size in ROUGH]
    bells = range(len(ROUGH_RANGES), len(ROUGH_RANGES) + len(SMOOTH_RANGES))
    smooth = [((0.0, size), (0, bell)) for bell in bells for size in SMOOTH]
    sizes, which = (np.array(each) for each in zip(((0.0, 0.0), (0, 0)), *rough, *smooth, strict=True))
    first, second = np.meshgrid(np.flatnonzero(sizes[:, 0]), np.flatnonzero(sizes[:, 1]), indexing="ij")
    pairs = np.stack([first.ravel(), second.ravel()], axis=1)
    both = _Fields(sizes[pairs].sum(axis=1), which[pairs].sum(axis=1))
    return _Fields(sizes, which), pairs, both


def _bells(apart: Array) -> Array:
    """Correlations (B, P, P) of patches that are so far apart (P, P): of rough ranges, then smooth ones."""
    rough = [np.exp(-apart / span) for span in ROUGH_RANGES]
    return np.stack(rough + [np.exp(-0.5 * (apart / span) ** 2) for span in SMOOTH_RANGES])


@dataclass(frozen=True, eq=False)
class _Weighed:
    """Some of `Explanations`; `shape` (T, dof, dof) is the covariance of a step over the white variance."""

    log_evidence: Array
    white: Array
    rough: Array
    rough_range: Array
    smooth: Array
    smooth_range: Array
    rough_size: Array
    smooth_size: Array
    shape: Array

    @property
    def likeliest(self) -> int:
        return int(np.argmax(self.log_evidence))

    @property
    def highest(self) -> float:
        return float(self.log_evidence[self.likeliest])


def _weighed(
    fields: _Fields, bells: Array, patched: Patched, whitened: Array, extent: float, least: float
) -> _Weighed:
    """How well pairs of fields explain the residuals, and what they make of them."""
    n, dof = whitened.shape
    columns = np.column_stack([patched.mean, whitened])
    halves, solved, root = _noise.solve_fields(1.0 / patched.count, bells, fields.bell, fields.size, columns)
    target, across = halves[:, :, :1], halves[:, :, 1:]
    normal = across.transpose(0, 2, 1) @ across
    damping = np.where(np.isinf(root), 1.0, EPS * np.trace(normal, axis1=1, axis2=2))
    shape = np.asarray(np.linalg.inv(normal + damping[:, None, None] * np.eye(dof)), np.float64)
    step = shape @ (across.transpose(0, 2, 1) @ target)
    free = n + patched.spare
    left = np.sum((target - across @ step) ** 2, axis=(1, 2)) + patched.spare * patched.scatter**2
    variance = np.maximum(left / max(free - dof, 1.0), least**2)
    known = ((PRIOR * extent) ** 2 / variance)[:, None, None] * normal
    occam = np.linalg.slogdet(np.eye(dof) + known)[1]
    evidence = -0.5 * (free * np.log(2.0 * np.pi * variance) + left / variance + occam)
    weights = (solved[:, :, :1] - solved[:, :, 1:] @ step)[:, :, 0]
    rough, smooth = (_seen(fields, part, bells, weights, whitened) for part in (0, 1))
    (rough_range, smooth_range), (rough_size, smooth_size) = fields.range.T, fields.size.T
    return _Weighed(
        evidence - root,
        np.asarray(np.sqrt(variance)),
        rough,
        rough_range,
        smooth,
        smooth_range,
        rough_size,
        smooth_size,
        shape,
    )


def _seen(fields: _Fields, part: int, bells: Array, weights: Array, whitened: Array) -> Array:
    """Sizes (T,) of the rough (part 0) or smooth (1) deviations that residuals show beside parameters' steps.

    Of their most likely courses, root mean square over the patches, from residuals that are solved by each
    covariance, (T, P). The columns (P, dof) that steps move the surface by are orthogonal, of length root P.
    """
    course = np.empty_like(weights)
    for bell in np.unique(fields.bell[:, part]):
        mine = fields.bell[:, part] == bell
        course[mine] = fields.size[mine, part, None] ** 2 * (weights[mine] @ bells[bell])
    course -= (course @ whitened) @ whitened.T / len(whitened)
    return np.asarray(np.sqrt(np.mean(course**2, axis=1)))


def _apart(patched: Patched, whitened: Array, extent: float, least: float) -> tuple[float, float]:
    """Evidence and size, as of a point, of white noise that the means of patches have to themselves.

    So it is where noise is correlated within patches only. The variances of the means and within patches
    are two numbers for one, which costs half the logarithm of how often the second is seen.
    """
    n, dof = whitened.shape
    if not patched.spare or not patched.scatter:
        return -np.inf, 0.0
    root = np.sqrt(patched.count)
    columns, target = root[:, None] * whitened, root * patched.mean
    rest = target - columns @ np.linalg.lstsq(columns, target, rcond=None)[0]
    variance = max(float(rest @ rest) / (n - dof), least**2)
    occam = np.linalg.slogdet(np.eye(dof) + (PRIOR * extent) ** 2 / variance * (columns.T @ columns))[1]
    means = -0.5 * (
        (n - dof) * np.log(2.0 * np.pi * np.e * variance) + dof * np.log(2.0 * np.pi * variance) + occam
    )
    within = -0.5 * patched.spare * np.log(2.0 * np.pi * np.e * max(patched.scatter, least) ** 2)
    return float(means + within + np.log(root).sum() - 0.5 * np.log(patched.spare)), float(np.sqrt(variance))


def _unexplained(patched: Patched, dof: int, found: float, extent: float) -> float | None:
    """What white noise of the points' own scatter would gain on the evidence that was found."""
    if patched.scatter == 0.0:
        return None
    variance, free = patched.scatter**2, len(patched.mean) + patched.spare
    occam = 0.5 * dof * np.log1p((PRIOR * extent) ** 2 * patched.count.sum() / variance)
    ideal = -0.5 * (free * np.log(2.0 * np.pi * variance) + free - dof) + 0.5 * np.log(patched.count).sum()
    return float(ideal - occam - found)


def _whitening(jacobian: Array) -> Array:
    """Directions (dof, dof), in columns, that move the surface by 1 in the mean square, each by itself."""
    if not jacobian.shape[1]:
        return np.empty((0, 0))
    _, sizes, directions = np.linalg.svd(jacobian / np.sqrt(len(jacobian)), full_matrices=False)
    return np.asarray(directions.T / np.maximum(sizes, EPS * max(float(sizes[0]), TINY)))
