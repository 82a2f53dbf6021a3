"""Does a primitive explain a cloud, and which of two explains it better?

A surface explains a cloud when what is left over looks like noise. Where a shape is wrong, the residuals of
whole patches of the cloud lean to one side; noise does not, even if it is correlated from one point of a
scan to the next.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Self

import numpy as np
from scipy.spatial import cKDTree

from fitting.cloud import Cloud
from fitting.geometry import Array
from fitting.limits import Limits, dof_within
from fitting.noise import LEAST_OUTLIERS, NoiseModel, exact_points
from fitting.primitives import Primitive
from fitting.refine import linearize
from fitting.result import ErrorSummary, NoiseSummary

OUTLIER = 4.0
"""Points farther than this many noise scales are rejected as outliers."""

SMALL_DEFORMATION = 0.01
"""Points this close, in extents, to a surface that has exact points are no outliers."""

SMALLEST_INLIER_SHARE = 0.35
"""Share of the points that must be near a surface, beside the ones that its parameters may choose."""

LARGEST_SECOND_SURFACE = 0.22
"""Share of the points that may be rejected and lie on a surface of their own."""

MANY_REJECTED = 0.3
LARGEST_FLAT_SHARE = 0.12
"""Where more than this share of the points is rejected, more than that share of those must not be on one."""

FLAT = 0.4
FLAT_NEIGHBOURS = 12
"""A rejected point lies on a surface where it and its neighbours among the rejected scatter about their plane
by less than this share of what they scatter in its narrower direction; of points in space 3 % do."""

LARGEST_STRUCTURE = 0.3
"""Largest share of variance between patches that a surface which explains a cloud leaves ..."""

CHANCE = 6.0
"""... to which chance adds up to this over the number of points."""

LARGEST_BIASED_STRUCTURE = 0.6
"""The same beside exact points: noise with a mean, as the benchmark has it, reaches 0.4 there."""

LARGEST_EXCESS = 2.5
EXCESS_STRUCTURE = 0.15
EXCESS_TREND = 35.0
"""Noise that is this many times what neighbours scatter about local planes must show less structure than
this, or the product of its excess and its trend must be smaller than that.

Correlated noise shows the one or the other, a wrong shape mostly both."""

HUGE_EXCESS = 10.0
"""From this excess on the trend is not asked."""

LARGE_EXCESS = 6.5
LITTLE_STRUCTURE = 0.08
LITTLE_CORRELATION = 0.15
"""From this excess on the structure of noise that is correlated must be less: noise that smooth is rare."""

COARSE = 0.01
"""Such noise beyond this share of the extent is a wrong shape whatever its trend."""

LARGEST_SCATTER = 0.04
"""Noise beyond this share of the extent is a volume rather than a surface.

Less, by four times its parameters, for a surface that has few points to hug. Twice as much is allowed
beside a few exact points, and any noise beside many."""

CLEAR_STRUCTURE = 0.15
"""A share and a correlation below this are those of noise ..."""

CLEAR_NOISE = 2.0
"""... if it is no larger than this many times what neighbours scatter about local planes ..."""

CLEAR_TREND = 4.0
"""... and if the trend is within this many standard deviations of what noise alone shows.

A trend beyond it even for noise that is correlated as the residuals are makes a kind doubtful, whatever the
ranking says, and suspect beside some structure; and so does larger noise ..."""

DOUBTFUL_TREND = 15.0
"""... if the product of its excess over that of neighbours and the trend is beyond this."""

LARGE_EXACT_SHARE = 0.25
"""An exact subset of this share is no accident of sampling (two generatrices reach 0.22)."""

SAFE_EXACT_SHARE = 0.5
"""With as many exact points, a small deformation of the others leaves no doubt."""

LARGEST_DEFORMATION = 0.05
"""Rejected points of an otherwise exact surface may be structured if they are this close, in extents."""

MAGNITUDES = 0.6
"""How much a share of variance between patches counts for magnitudes: noise itself grows with range."""

DOMINANT_EXACT_SHARE = 0.75
"""With as many exact points the others may be anything, a piece of a neighbouring surface, too."""

MOST_PATCHES = 16
PATCH_POINTS = 8
CLOSE_NEIGHBOURS = 3
"""Structure is looked for between at most so many patches of at least so many points, and among so many
neighbours; not at all in clouds of fewer than two patches, or where the noise is within the rounding."""

ROUNDING_NOISE = 0.3
"""Standard deviation of a rounded coordinate, in steps: 1 / sqrt 12."""

HIGHEST_CORRELATION = 0.9
"""Neighbours count as correlated by at most this when the effective number of points is derived."""

EQUAL_SHARES = 0.1
"""Exact shares that differ by less than this, relatively, are equal."""

LEAST_GAIN = 0.01
"""Log-likelihood a point that a more general kind must bring: a variance lower by 2 %.

With very many points less than that is significant, but noise is never quite as it is modelled."""

STRONG_EVIDENCE = 6.0
"""Difference in BIC that decides; Kass and Raftery, "Bayes factors", JASA 90, 1995, section 3.2."""


@dataclass(frozen=True)
class Evidence:
    """What a primitive leaves over of a cloud, in the normalised frame.

    Attributes
    ----------
    primitive : the surface that was judged
    free : parameters of it that no fixed value and no active limit holds
    small : too few points to reject any
    distance : (M,) signed distances of the working points
    exact : (M,) mask of the points on the surface within the rounding
    inlier : (M,) mask of the points not rejected as outliers
    reach : distance beyond which they are, infinite in small clouds, where none is
    noise : the mixture of noise and outliers that makes the distances of the others most likely
    noise_scale : standard deviation of the noise; of small clouds, in which none is an outlier, of all points
    second_surface : share of the points that are far from it and lie on a surface of their own
    structure : share of the variance of the inliers' residuals that is between patches of the cloud, or
        follows a quadratic in space
    correlation : of the residuals of neighbouring inliers, 0 for independent noise
    trend : how far they follow that quadratic, in standard deviations of what pure noise shows
    rounding : of the coordinates; their noise is not smaller
    """

    primitive: Primitive
    free: int
    small: bool
    distance: Array
    exact: np.ndarray
    inlier: np.ndarray
    reach: float
    noise: NoiseModel
    noise_scale: float
    second_surface: float
    structure: float
    correlation: float
    trend: float
    rounding: float

    @classmethod
    def weigh(cls, primitive: Primitive, cloud: Cloud, limits: Limits | None = None) -> Self:
        """Of a primitive, in the frame of the cloud, that was fitted to it within limits."""
        dof = dof_within(primitive.kind, limits)
        free = primitive.dof - (0 if limits is None else limits.held(primitive.row()))
        small = cloud.is_small(dof)
        distance = primitive.signed_distance(cloud.working)
        absolute = np.abs(distance)
        exact = exact_points(absolute, cloud.tolerance, dof)
        spare = max(len(absolute) - free, 1)
        rest = distance if exact.all() else distance[~exact]
        noise = NoiseModel.of(rest, ROUNDING_NOISE * cloud.tolerance, cloud.extent)
        inlier, reach, seen, second = np.ones_like(exact), np.inf, np.empty(0, np.intp), 0.0
        if exact.all():
            noise_scale, reach = 0.0, SMALL_DEFORMATION * cloud.extent
        elif small:
            noise_scale = float(np.sqrt(np.sum(absolute**2) / spare))
        else:
            noise_scale = noise.scale
            if not exact.any():
                noise_scale *= float(np.sqrt(len(absolute) / spare))
            nearby = SMALL_DEFORMATION * cloud.extent if exact.any() else cloud.tolerance
            reach = max(OUTLIER * noise_scale, nearby)
            inlier = exact | (absolute <= reach)
            seen = cloud.sample[(inlier & ~exact)[cloud.sample]]
            far = absolute > LARGEST_DEFORMATION * cloud.extent if exact.any() else ~inlier
            second = _on_surfaces(cloud.working[cloud.sample[far[cloud.sample]]]) / len(cloud.sample)
        structure = correlation = trend = 0.0
        if len(seen) >= 2 * PATCH_POINTS and noise_scale > cloud.tolerance:
            points, residual = cloud.working[seen], distance[seen]
            feet = points - residual[:, None] * primitive.gradient(points)
            share, trend = _trend(primitive, feet, residual)
            structure = max(_structure(feet @ cloud.axes, residual), share)
            correlation = _correlation(feet, residual)
        return cls(
            primitive,
            free,
            small,
            distance,
            exact,
            inlier,
            reach,
            noise,
            noise_scale,
            second,
            structure,
            correlation,
            trend,
            cloud.tolerance,
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


class Standing(IntEnum):
    """How good an explanation is.

    `SUSPECT` ones are refused unless another kind is good enough: then they compete, too.
    `DOUBTFUL` is enough if no other kind explains the cloud better, `ACCEPTABLE` if no other probable one
    does, `CLEAR` if no simpler probable one does: what it leaves over is noise. With `CERTAIN` only the
    simpler kinds that the surface nearly is are asked.
    """

    REFUSED = 0
    SUSPECT = 1
    DOUBTFUL = 2
    ACCEPTABLE = 3
    CLEAR = 4
    CERTAIN = 5


@dataclass(frozen=True)
class Verdict:
    """A standing and the sentence that explains it."""

    standing: Standing
    reason: str


def judge(evidence: Evidence, cloud: Cloud, max_error: float | None, only: bool) -> Verdict:
    """Whether the evidence is good enough, by the caller's threshold or by the cloud's own noise.

    Parameters
    ----------
    max_error : the caller's threshold as in `Config`, or None
    only : no other kind is allowed, so that no evidence against others is needed
    """
    n = len(cloud.working)
    if n == evidence.free and not only:
        return Verdict(Standing.REFUSED, f"{n} points determine it exactly and leave none to check it with")
    share, least = evidence.inlier_share, min(SMALLEST_INLIER_SHARE + evidence.free / n, 1.0)
    if share < least:
        return Verdict(Standing.REFUSED, f"only {share:.0%} of the points are near it (at least {least:.0%})")
    if evidence.second_surface > LARGEST_SECOND_SURFACE:
        second = (
            f"{evidence.second_surface:.0%} of the points are far from it and form a surface of their own"
        )
        return Verdict(Standing.REFUSED, f"{second} (at most {LARGEST_SECOND_SURFACE:.0%})")
    rejected = 1.0 - share
    if rejected > MANY_REJECTED and evidence.second_surface > LARGEST_FLAT_SHARE * rejected:
        flat = evidence.second_surface / rejected
        return Verdict(
            Standing.REFUSED,
            f"{rejected:.0%} of the points are far from it, of which {flat:.0%} form a surface of their own",
        )
    if max_error is not None:
        return _by_threshold(evidence.mean_inlier_distance / cloud.diagonal, max_error)
    if evidence.exact.all():
        return Verdict(Standing.CERTAIN, "every point lies on it within the rounding of the coordinates")
    if evidence.exact.any():
        return _by_exact_points(evidence, cloud.extent)
    if n < 2 * evidence.free and not only:
        return Verdict(Standing.REFUSED, f"{n} points that do not lie on it are too few to check it with")
    return _by_noise(evidence, cloud)


def judge_all(
    evidence: Evidence, cloud: Cloud, mean_error: float, max_error: float | None, only: bool
) -> Verdict:
    """As `judge`, under a criterion that counts every point.

    The threshold is held against `mean_error`, that of all points from the answer, in diagonals. Without one
    a kind that is the only one allowed is not refused: the caller knows what it is.
    """
    if max_error is not None:
        return _by_threshold(mean_error, max_error)
    verdict = judge(evidence, cloud, None, only)
    if only and verdict.standing == Standing.REFUSED:
        return Verdict(Standing.DOUBTFUL, f"the only kind allowed, though {verdict.reason}")
    return verdict


def _by_threshold(mean: float, max_error: float) -> Verdict:
    standing, relation = (
        (Standing.CERTAIN, "is within") if mean <= max_error else (Standing.REFUSED, "exceeds")
    )
    return Verdict(standing, f"mean error {mean:.2e} of the diagonal {relation} max_error {max_error:.2e}")


def _by_exact_points(evidence: Evidence, extent: float) -> Verdict:
    """Some points are exact: the others must be noise about the surface, or a small deformation of it."""
    share, scatter = evidence.exact_share, evidence.noise_scale / extent
    exact, spread = f"{share:.0%} of the points lie on it exactly", _spread(evidence, extent)
    large = share >= LARGE_EXACT_SHARE
    if not large and scatter > 2.0 * LARGEST_SCATTER:
        return Verdict(Standing.REFUSED, f"{exact}; the others: {spread}, which is no surface")
    if evidence.structure <= LARGEST_BIASED_STRUCTURE or share >= DOMINANT_EXACT_SHARE:
        return Verdict(Standing.CERTAIN if large else Standing.ACCEPTABLE, f"{exact}; the others: {spread}")
    rest = float(np.abs(evidence.distance[~evidence.exact]).mean()) / extent
    if rest <= (LARGEST_DEFORMATION if large else SMALL_DEFORMATION):
        standing = Standing.CERTAIN if share >= SAFE_EXACT_SHARE else Standing.ACCEPTABLE
        return Verdict(standing, f"{exact}; the others are a deformation by {rest:.2e} of the extent")
    return Verdict(Standing.REFUSED, f"{exact}, but the others form a structure of their own: {spread}")


def _by_noise(evidence: Evidence, cloud: Cloud) -> Verdict:
    """No point is exact: the residuals must be small and know nothing of each other."""
    spread = _spread(evidence, cloud.extent)
    largest = min(LARGEST_STRUCTURE + CHANCE / len(evidence.distance), LARGEST_BIASED_STRUCTURE)
    if evidence.structure > largest:
        limit = 1.0 / np.sqrt(1.0 - largest)
        return Verdict(Standing.REFUSED, f"the shape is systematically off: {spread} (at most {limit:.2f})")
    most = LARGEST_SCATTER * max(1.0 - 4.0 * evidence.free / len(evidence.distance), 0.25)
    if evidence.noise_scale > most * cloud.extent:
        return Verdict(Standing.REFUSED, f"{spread}: that is no surface (at most {most:.2e})")
    excess = evidence.noise_scale / max(cloud.local_noise, ROUNDING_NOISE * cloud.tolerance)
    smooth = excess > LARGE_EXCESS and evidence.correlation > LITTLE_CORRELATION
    allowed = LITTLE_STRUCTURE if smooth else EXCESS_STRUCTURE
    structured = excess > LARGEST_EXCESS and evidence.structure > allowed
    coarse = smooth and evidence.noise_scale > COARSE * cloud.extent
    trending = evidence.trend > CLEAR_TREND * points_alike(evidence.correlation)
    if trending and evidence.structure > EXCESS_STRUCTURE:
        return Verdict(
            Standing.SUSPECT,
            f"the shape is systematically off: {spread}, and they follow a quadratic in space",
        )
    if structured and (coarse or excess > HUGE_EXCESS or excess * evidence.trend > EXCESS_TREND):
        return Verdict(
            Standing.SUSPECT,
            f"the shape is systematically off: {spread}, and {excess:.1f} times that of neighbours "
            f"(at most {LARGEST_EXCESS})",
        )
    uncorrelated = excess > CLEAR_NOISE and excess * evidence.trend > DOUBTFUL_TREND
    if uncorrelated or trending:
        return Verdict(Standing.DOUBTFUL, spread)
    clear = (
        evidence.trend <= CLEAR_TREND
        and max(evidence.structure, evidence.correlation) <= CLEAR_STRUCTURE
        and excess <= CLEAR_NOISE
    )
    return Verdict(Standing.CLEAR if clear else Standing.ACCEPTABLE, spread)


def _spread(evidence: Evidence, extent: float) -> str:
    ratio = 1.0 / np.sqrt(max(1.0 - evidence.structure, 1e-9))
    return (
        f"residuals scatter by {evidence.noise_scale / extent:.2e} of the extent, "
        f"{ratio:.2f} times the noise within a patch"
    )


def better(a: Evidence, b: Evidence) -> float:
    """How much better `a` explains the cloud than `b`: a difference in BIC, negative where `b` is better.

    Where either has exact points, the share of them decides and the simpler kind wins among equal shares.
    Otherwise BIC: the likelihoods are those of the noise models, and the points count for as many as their
    correlation leaves. The more general kind must gain `LEAST_GAIN` a point, too. Parameters that are held
    make the simpler kind cheaper, not the more general one: that may nearly be the simpler one all the same.
    Source: Schwarz, "Estimating the dimension of a model", Annals of Statistics 6, 1978.
    """
    general = b.primitive.dof - a.primitive.dof
    if a.exact.any() or b.exact.any():
        if abs(a.exact_share - b.exact_share) > EQUAL_SHARES * max(a.exact_share, b.exact_share):
            return np.inf if a.exact_share > b.exact_share else -np.inf
        return np.inf if general > 0 else -np.inf
    n = max(len(a.distance) / points_alike(min(a.correlation, b.correlation)), 1.0)
    gain = (a.noise.log_likelihood - b.noise.log_likelihood) / len(a.distance)
    side = float(np.sign(general))
    parameters = max(abs(general), side * (b.free - a.free))
    return n * 2.0 * (gain + side * LEAST_GAIN) + side * parameters * float(np.log(n))


def points_alike(correlation: float) -> float:
    """How many points share one piece of information where neighbours are correlated; 1 for independent ones.

    The integral of an exponential correlation over the surface, in units of the points' spacing; the number
    of points over it is the effective one. Source: Cressie, "Statistics for spatial data", 1993, section 1.3.
    """
    if correlation <= 0.0:
        return 1.0
    return 1.0 + 2.0 * np.pi / float(np.log(min(correlation, HIGHEST_CORRELATION))) ** 2


def summarize(
    primitive: Primitive, evidence: Evidence, points: Array, diagonal: float, scale: float
) -> ErrorSummary:
    """The distances of all points (N, 3), restored to input units by `scale`."""
    signed = primitive.signed_distance(points)
    distance = np.abs(signed)
    mean = float(distance.mean())
    return ErrorSummary(
        rms=scale * float(np.sqrt(np.mean(distance**2))),
        mean=scale * mean,
        p95=scale * float(np.percentile(distance, 95.0)),
        max=scale * float(distance.max()),
        zone=scale * float(np.ptp(signed)),
        relative_mean=mean / diagonal,
        inlier_rms=scale * float(np.sqrt(np.mean(distance[distance <= evidence.reach] ** 2))),
        inlier_share=evidence.inlier_share,
    )


def summarize_noise(evidence: Evidence, cloud: Cloud) -> NoiseSummary:
    """The noise about the judged primitive, restored to input units."""
    share = evidence.noise.outlier_share * (1.0 - evidence.exact_share)
    return NoiseSummary(
        scale=cloud.frame.scale * evidence.noise_scale,
        exact_share=evidence.exact_share,
        outlier_share=0.0 if evidence.small or share <= LEAST_OUTLIERS else share,
        quantisation_step=cloud.step,
    )


def _structure(feet: Array, residual: Array) -> float:
    """Share of the variance of the residuals that is between patches, less what noise alone would show.

    The feet (N, 3) are given along the principal axes of the cloud: so patches turn with it. They are made
    of the feet of the points on the surface, not of the points: noisy points that lie close together are
    those that happen to be displaced alike. Magnitudes are looked at as well as signed residuals, because
    two sheets of a cloud on either side of a surface have feet that mix; they count less.
    """
    patches = _patches(feet)
    return max(_between(residual[patches]), MAGNITUDES * _between(np.abs(residual)[patches]))


def _patches(feet: Array) -> np.ndarray:
    """Indices (k, n) of k patches of equal size: halves along the widest coordinate, again and again."""
    patches = [np.arange(len(feet))]
    while len(patches) < MOST_PATCHES and len(feet) >= 2 * PATCH_POINTS * len(patches):
        halves = []
        for patch in patches:
            order = patch[np.argsort(feet[patch, np.argmax(np.ptp(feet[patch], axis=0))], kind="stable")]
            halves += [order[: len(order) // 2], order[(len(order) + 1) // 2 :]]
        patches = halves
    shortest = min(len(patch) for patch in patches)
    return np.array([patch[:shortest] for patch in patches])


def _between(values: Array) -> float:
    """Adjusted share of variance between the rows of (k, n): 0 for noise, 1 where each row is constant."""
    k, n = values.shape
    within = float(np.sum((values - values.mean(axis=1, keepdims=True)) ** 2)) / (k * (n - 1))
    total = float(np.sum((values - values.mean()) ** 2)) / (k * n - 1)
    return 1.0 - within / total if total > 0.0 else 0.0


def _on_surfaces(points: Array) -> int:
    """How many of the points (N, 3) lie on a surface with their neighbours among them."""
    if len(points) < 2 * FLAT_NEIGHBOURS:
        return 0
    offsets = points[cKDTree(points).query(points, k=FLAT_NEIGHBOURS)[1]]
    offsets -= offsets.mean(axis=1, keepdims=True)
    squares = np.linalg.eigvalsh(np.einsum("nki,nkj->nij", offsets, offsets))
    return int(np.count_nonzero(squares[:, 0] < FLAT**2 * squares[:, 1]))


def _correlation(feet: Array, residual: Array) -> float:
    """Correlation of the residuals of points whose feet on the surface are neighbours."""
    neighbours = cKDTree(feet).query(feet, k=1 + CLOSE_NEIGHBOURS)[1][:, 1:]
    first, second = residual[:, None], residual[neighbours]
    power = float(np.mean(first**2 + second**2)) / 2.0
    return float(np.mean(first * second)) / power if power > 0.0 else 0.0


def _trend(primitive: Primitive, feet: Array, residual: Array) -> tuple[float, float]:
    """How much a quadratic in space explains of the residuals, beyond the fit's own parameters.

    It sees what spans the whole cloud, such as the curvature of a shallow arc, which neighbours cannot tell
    from noise. Returned are the share of the sum of squares that it explains, less what noise alone would
    show, and the excess of that sum over its mean under independent noise, where it follows chi^2, in
    standard deviations.
    """
    x, y, z = feet.T
    quadratic = np.stack([np.ones_like(x), x, y, z, x * x, y * y, z * z, x * y, x * z, y * z], axis=1)
    fitted = np.linalg.qr(linearize(primitive, feet)[1])[0]
    beyond, sizes, _ = np.linalg.svd(quadratic - fitted @ (fitted.T @ quadratic), full_matrices=False)
    beyond = beyond[:, sizes > 1e-6 * np.sqrt(len(feet))]
    terms, variance = beyond.shape[1], float(np.mean(residual**2))
    if terms == 0 or variance == 0.0:
        return 0.0, 0.0
    explained = float(np.sum((beyond.T @ residual) ** 2)) / variance
    share = (explained - terms) / max(len(residual) - terms, 1)
    return share, (explained - terms) / float(np.sqrt(2.0 * terms))
