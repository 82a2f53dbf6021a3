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

from fitting.geometry import Array

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
    rough, rough_range : (T,) of the rough field, the range over the extent
    smooth, smooth_range : (T,) of the smooth one as it shows beside what steps of the parameters take of it
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
    that it moves the surface by itself, may move it by `PRIOR` extents in the mean square.
    """
    directions = _whitening(patched.jacobian)
    whitened = patched.jacobian @ directions
    n, dof = whitened.shape
    target = np.asfortranarray(np.column_stack([patched.mean, whitened]))
    fields, roots, solved = [], [], []
    for field in _fields(patched.apart):
        root, failed = dpotrf(np.diag(1.0 / patched.count) + field.covariance, lower=1, clean=0)
        if not failed:
            fields.append(field)
            roots.append(root)
            solved.append(dtrsm(1.0, root, target, lower=1))
    columns = np.array(solved)
    normal = columns[:, :, 1:].transpose(0, 2, 1) @ columns[:, :, 1:]
    pull = columns[:, :, 1:].transpose(0, 2, 1) @ columns[:, :, :1]
    damping = 1e-10 * np.trace(normal, axis1=1, axis2=2)[:, None, None] / max(dof, 1) * np.eye(dof)
    rest = (columns[:, :, :1] - columns[:, :, 1:] @ np.linalg.solve(normal + damping, pull))[:, :, 0]
    free = n + patched.spare
    left = np.sum(rest**2, axis=1) + patched.spare * patched.scatter**2
    variance = np.maximum(left / max(free - dof, 1.0), least**2)
    volume = np.array([np.log(root.diagonal()).sum() for root in roots])
    steps = np.eye(dof) + (PRIOR * extent) ** 2 * normal / variance[:, None, None]
    evidence = -0.5 * (free * np.log(2.0 * np.pi * variance) + left / variance) - volume
    evidence -= 0.5 * np.linalg.slogdet(steps)[1]
    scale = np.sqrt(variance)
    taken = np.linalg.qr(whitened)[0]
    best = int(np.argmax(evidence))
    shape = np.linalg.pinv(normal[best] + damping[best])
    spread = scale[best] * np.sqrt(np.einsum("ij,jk,ik->i", directions, shape, directions))
    return Explanations(
        evidence,
        scale,
        scale * np.array([field.rough for field in fields]),
        np.array([field.rough_range for field in fields]),
        np.array([_seen(*each, taken) for each in zip(fields, roots, rest, strict=True)]),
        np.array([field.smooth_range for field in fields]),
        patched.hidden,
        spread,
        _unexplained(patched, dof, log_mean(evidence), extent),
    )


def _seen(field: "_Field", root: Array, rest: Array, taken: Array) -> float:
    """Size of the smooth deviation that residuals show, beside what steps of the parameters take of it.

    Its most likely course, root mean square over the patches, from residuals (P,) whitened by `root`.
    """
    if field.bell is None:
        return 0.0
    course = field.smooth**2 * (field.bell @ dtrsm(1.0, root, rest[:, None], lower=1, trans_a=1)[:, 0])
    return float(np.sqrt(np.mean((course - taken @ (taken.T @ course)) ** 2)))


@dataclass(frozen=True, eq=False)
class _Field:
    """A pair of fields: sizes over the white noise, ranges over the extent, and their covariance (P, P)."""

    rough: float
    rough_range: float
    smooth: float
    smooth_range: float
    covariance: Array
    bell: Array | None


def _unexplained(patched: Patched, dof: int, found: float, extent: float) -> float | None:
    """What white noise of the points' own scatter would gain on the evidence that was found."""
    if patched.scatter == 0.0:
        return None
    variance, free = patched.scatter**2, len(patched.mean) + patched.spare
    occam = 0.5 * dof * np.log1p((PRIOR * extent) ** 2 * patched.count.sum() / variance)
    ideal = -0.5 * (free * np.log(2.0 * np.pi * variance) + free - dof) + 0.5 * np.log(patched.count).sum()
    return float(ideal - occam - found)


def _fields(apart: Array) -> list[_Field]:
    """None, the rough ones, the smooth ones, and each of both."""
    nothing = np.zeros_like(apart)
    rough = [(0.0, 0.0, nothing)]
    rough += [(size, span, size**2 * np.exp(-apart / span)) for span in ROUGH_RANGES for size in ROUGH]
    bells = [(span, np.exp(-0.5 * (apart / span) ** 2)) for span in SMOOTH_RANGES]
    found = [_Field(size, span, 0.0, 0.0, covariance, None) for size, span, covariance in rough]
    for reach, bell in bells:
        for height in SMOOTH:
            smooth = height**2 * bell
            found += [
                _Field(size, span, height, reach, covariance + smooth, bell)
                for size, span, covariance in rough
            ]
    return found


def _whitening(jacobian: Array) -> Array:
    """Directions (dof, dof), in columns, that move the surface by 1 in the mean square, each by itself."""
    if not jacobian.shape[1]:
        return np.empty((0, 0))
    sizes, vectors = np.linalg.eigh(jacobian.T @ jacobian / len(jacobian))
    return np.asarray(vectors / np.sqrt(np.maximum(sizes, 1e-12 * max(sizes.max(), 1e-300))))
