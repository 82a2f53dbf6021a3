"""The fields of `fitting.fields` in NumPy, one line a formula: what the compiled ones are held against."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from primfit.fitting.fields.fields import (
    EPS,
    PRIOR,
    ROUGH,
    ROUGH_RANGES,
    SMOOTH,
    SMOOTH_RANGES,
    Explanations,
    Patched,
    log_mean,
)
from primfit.fitting.geometry.vectors import TINY, Array


def patched(
    patch: np.ndarray, grain: np.ndarray, residual: Array, jacobian: Array, place: Array, turn: float = 0.0
) -> Patched:
    """`Patched.of`"""
    count, means, _ = _means(patch, np.column_stack([residual, jacobian, place]))
    dof = jacobian.shape[1]
    between = means[:, None, 1 + dof :] - means[None, :, 1 + dof :]
    if turn:
        between = np.minimum(np.abs(between), turn - np.abs(between))
    within, count_within = _scatter(patch, residual)
    scatter, count_scatter = _scatter(grain, residual)
    return Patched(
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


def explanations(patched: Patched, extent: float, least: float) -> Explanations:
    """Of residuals with fewer parameters than patches; `least` is the smallest noise of a point.

    For each pair of fields the white noise is the most likely one, the parameters take one step of
    generalized least squares, and Occam's factor is that of a normal prior by which each of them, turned so
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
    halves, solved, root = _solved(1.0 / patched.count, bells, fields.bell, fields.size, columns)
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


def _solved(
    white: Array, bells: Array, which: NDArray[np.int64], sizes: Array, columns: Array
) -> tuple[Array, Array, Array]:
    """L^-1 columns  and  C^-1 columns, (T, P, K),  of the covariances C = L L^T, and log det L (T,)."""
    halves, solved = np.zeros((2, len(which), *columns.shape))
    root = np.zeros(len(which))
    for t, (bell, size) in enumerate(zip(which, sizes, strict=True)):
        covariance = np.diag(white) + np.einsum("f,fij->ij", size**2, bells[bell])
        try:
            lower = np.linalg.cholesky(covariance)
        except np.linalg.LinAlgError:
            root[t] = np.inf
            continue
        halves[t] = solve_triangular(lower, columns, lower=True)
        solved[t] = solve_triangular(lower.T, halves[t])
        root[t] = np.log(lower.diagonal()).sum()
    return halves, solved, root


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
