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
from typing import Self

import numpy as np
from scipy.linalg.blas import dtrsm
from scipy.linalg.lapack import dpotrf

from fitting.geometry import TINY, Array

ROUGH = (0.3, 1.0, 3.0)
"""Standard deviations of the rough field, over that of the white noise: from what is hardly seen in a patch
to nearly all of the noise."""

ROUGH_RANGES = (0.1, 0.3, 1.0)
"""Its ranges, over the extent: from a patch to the whole cloud."""

SMOOTH = (1.0, 3.0, 10.0, 30.0)
"""Standard deviations of the smooth field, over that of the white noise: from one that patches just show to
that of a wrong kind under little noise."""

SMOOTH_RANGES = (0.3, 2.0)
"""Its ranges, over the extent: waves and bulges of a third of the cloud, and bows of all of it."""

UNDETERMINED = 1e-12
"""Directions that move the surface by less than this, over the one that moves it most, are not seen."""

DAMPING = 1e-12
"""Added to what steps are solved from, over its trace: directions that are not seen stay where they are."""

PRIOR = 0.1
"""Extents by which a parameter may move the surface: that a cloud lies on it is known beforehand."""


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
    _, place = np.unique(number, return_inverse=True)
    count = np.bincount(place).astype(np.float64)
    means = np.stack([np.bincount(place, column) for column in columns.T], axis=1) / count[:, None]
    return count, means, place


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
    nothing, rough, smooth = (
        _Field(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        _rough(patched.apart),
        _smooth(patched.apart),
    )
    alone = [_weighed(field, patched, whitened, extent, least) for field in (nothing, *rough, *smooth)]
    helps = [each.log_evidence > alone[0].log_evidence for each in alone[1:]]
    pairs = [
        _both(one, two)
        for one, useful in zip(rough, helps, strict=False)
        for two, too in zip(smooth, helps[len(rough) :], strict=True)
        if useful and too
    ]
    found = [*alone, *(_weighed(field, patched, whitened, extent, least) for field in pairs)]
    useless = np.full(len(rough) * len(smooth) - len(pairs), -np.inf)
    best = max(found, key=lambda each: each.log_evidence)
    spread = best.white * np.sqrt(np.einsum("ij,jk,ik->i", directions, best.shape, directions))

    def column(name: str) -> Array:
        return np.concatenate([[getattr(each, name) for each in found], np.zeros_like(useless)])

    evidence = np.concatenate([[each.log_evidence for each in found], useless])
    return Explanations(
        evidence,
        np.concatenate([[each.white for each in found], np.full_like(useless, best.white)]),
        column("rough"),
        column("rough_range"),
        column("smooth"),
        column("smooth_range"),
        column("rough_size"),
        column("smooth_size"),
        *_apart(patched, whitened, extent, least),
        patched.hidden,
        spread,
        _unexplained(patched, whitened.shape[1], log_mean(evidence), extent),
    )


@dataclass(frozen=True, eq=False)
class _Field:
    """A pair of fields: sizes over the white noise, ranges over the extent, and their covariances (P, P)."""

    rough_size: float
    rough_range: float
    smooth_size: float
    smooth_range: float
    rough: Array | float
    smooth: Array | float


def _rough(apart: Array) -> list[_Field]:
    found = [(span, np.exp(-apart / span)) for span in ROUGH_RANGES]
    return [_Field(size, span, 0.0, 0.0, size**2 * bell, 0.0) for span, bell in found for size in ROUGH]


def _smooth(apart: Array) -> list[_Field]:
    found = [(span, np.exp(-0.5 * (apart / span) ** 2)) for span in SMOOTH_RANGES]
    return [_Field(0.0, 0.0, size, span, 0.0, size**2 * bell) for span, bell in found for size in SMOOTH]


def _both(rough: _Field, smooth: _Field) -> _Field:
    return _Field(
        rough.rough_size,
        rough.rough_range,
        smooth.smooth_size,
        smooth.smooth_range,
        rough.rough,
        smooth.smooth,
    )


@dataclass(frozen=True, eq=False)
class _Explanation:
    """One of `Explanations`; `shape` (dof, dof) is the covariance of a step over the white variance."""

    log_evidence: float
    white: float
    rough: float
    rough_range: float
    smooth: float
    smooth_range: float
    rough_size: float
    smooth_size: float
    shape: Array


def _weighed(field: _Field, patched: Patched, whitened: Array, extent: float, least: float) -> _Explanation:
    """How well a pair of fields explains the residuals, and what it makes of them."""
    n, dof = whitened.shape
    covariance = np.diag(1.0 / patched.count) + field.rough + field.smooth
    root, singular = dpotrf(covariance, lower=1, clean=0)
    if singular:
        return _Explanation(-np.inf, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, np.zeros((dof, dof)))
    solved = dtrsm(1.0, root, np.column_stack([patched.mean, whitened]), lower=1)
    target, columns = solved[:, 0], solved[:, 1:]
    normal = columns.T @ columns
    shape = np.linalg.inv(normal + DAMPING * np.trace(normal) * np.eye(dof)) if dof else normal
    rest = target - columns @ (shape @ (columns.T @ target))
    free = n + patched.spare
    left = float(rest @ rest) + patched.spare * patched.scatter**2
    variance = max(left / max(free - dof, 1.0), least**2)
    occam = float(np.linalg.slogdet(np.eye(dof) + (PRIOR * extent) ** 2 / variance * normal)[1])
    evidence = -0.5 * (free * np.log(2.0 * np.pi * variance) + left / variance + occam)
    rough, smooth = _seen(field, root, rest, whitened)
    return _Explanation(
        float(evidence - np.log(root.diagonal()).sum()),
        float(np.sqrt(variance)),
        rough,
        field.rough_range,
        smooth,
        field.smooth_range,
        field.rough_size,
        field.smooth_size,
        shape,
    )


def _seen(field: _Field, root: Array, rest: Array, whitened: Array) -> tuple[float, float]:
    """Sizes of the rough and of the smooth deviation that residuals show beside steps of the parameters.

    Of their most likely courses, root mean square over the patches, from residuals (P,) whitened by `root`.
    The columns (P, dof) that steps move the surface by are orthogonal, of length root P.
    """
    weights = dtrsm(1.0, root, rest[:, None], lower=1, trans_a=1)[:, 0]
    sizes = []
    for part in (field.rough, field.smooth):
        course = part @ weights if isinstance(part, np.ndarray) else np.zeros_like(rest)
        course = course - whitened @ (whitened.T @ course) / len(course)
        sizes.append(float(np.sqrt(np.mean(course**2))))
    return sizes[0], sizes[1]


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
    return np.asarray(directions.T / np.maximum(sizes, UNDETERMINED * max(float(sizes[0]), TINY)))
