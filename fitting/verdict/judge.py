"""The comparison: which kind, which others as well, or none of these."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..cloud.cloud import Cloud
from ..fields.fields import PRIOR, Explanations
from ..geometry.vectors import Array
from ..names import KINDS
from ..primitives import PRIMITIVES
from ..words import as_given, digits, part, percent, unlike
from .evidence import Evidence

Status = Literal["fitted", "ambiguous", "no_fit"]

DECIDED = 3.0
"""Log-odds from which a kind is told from another, 20 to 1: Kass and Raftery, "Bayes factors", JASA 90, 1995,
section 3.2, "strong"."""

MISTAKEN = 0.1
"""Share of clouds that a ranking knows nothing of: there the kinds are as likely as each other."""

FORM = 2e-3
"""A smooth deviation is one of sensor or part, and no other shape, where it is no larger than the noise, or
than this share of the extent: 0.2 mm on a hand's breadth, flatness K of ISO 2768-2, the usual one."""

SCATTER = 0.03
"""Noise beyond this share of the extent is a volume rather than a surface."""

PART = 0.22
"""Share of the points up to which some may be of another surface: segments take along a fifth of what is
beside them. Beyond it rejected ones on a surface of their own are a second segment; those near a surface are
more, and so are exact ones beside a volume."""

EQUAL_SHARES = 0.1
"""Exact shares that differ by less than this, relatively, are equal."""


@dataclass(frozen=True)
class Question:
    """What is asked of every kind: `max_error` as in `Config`, `tolerance` [length in the frame] or 0,
    whether one kind is allowed `only`, and whether the criterion `counts_all` points."""

    max_error: float | None
    tolerance: float
    only: bool
    counts_all: bool


@dataclass(frozen=True, eq=False)
class Claim:
    """A kind's claim on a cloud.

    Attributes
    ----------
    evidence : what its best surface leaves over
    prior : logarithm of its probability before that
    refusal : why it can't be, whatever the others are, as a clause, or nothing
    settled : it is accepted as it is; only simpler kinds that it nearly is are asked
    odds : logarithm of its probability, up to a constant that all kinds share
    foreign : the same of another shape near its surface
    words : a clause about the points and its surface, in input units
    """

    evidence: Evidence
    prior: float
    refusal: str
    settled: bool
    odds: float
    foreign: float
    words: str

    @property
    def kind(self) -> str:
        return self.evidence.primitive.kind

    @property
    def dof(self) -> int:
        return self.evidence.primitive.dof

    @property
    def standing(self) -> float:
        """How good an explanation it is, of whatever there is."""
        return max(self.odds, self.foreign)


@dataclass(frozen=True, eq=False)
class Decision:
    """What the cloud is: the best claim, and the others that are as good.

    `reason` is a clause that says why, about the surface of the claim `about`, which mostly is the best one.
    """

    status: Status
    best: Claim
    rivals: tuple[Claim, ...]
    reason: str
    about: Claim


def prior_of(probability: float | None) -> float:
    """Logarithm of a kind's probability before its evidence, from that of the ranking."""
    if probability is None:
        return -float(np.log(len(KINDS)))
    return float(np.log((1.0 - MISTAKEN) * probability + MISTAKEN / len(KINDS)))


def bearable(explained: Explanations, evidence: Evidence, tolerance: float) -> np.ndarray:
    """Mask (T,) of explanations by which the cloud is of this kind, and no other shape.

    Within patches rough noise may be hidden, too, of the size of the white one. A surface that has few points
    to hug must scatter less, by twice its parameters, down to half as much.
    """
    extent = evidence.cloud.extent
    form = max(FORM * extent, tolerance)
    seen = explained.smooth <= np.maximum(explained.white, form)
    hidden = explained.hidden <= np.maximum(2.0 * explained.white, form)
    most = SCATTER * extent * max(1.0 - 2.0 * evidence.free / len(evidence.distance), 0.5)
    return np.asarray(seen & hidden & (evidence.noise_scale <= most))


def claim(evidence: Evidence, probability: float | None, mean_error: float, question: Question) -> Claim:
    """Of a fitted kind with this probability in the ranking, or None without one.

    `mean_error` is the mean distance of all points from the answer, over the diagonal: what `max_error` is
    held against where every point counts.
    """
    cloud = evidence.cloud
    prior, odds, foreign = prior_of(probability), 0.0, -np.inf
    if evidence.explained is not None:
        mask = bearable(evidence.explained, evidence, question.tolerance)
        odds = evidence.explained.among(mask)
        foreign = evidence.explained.among(~mask) + evidence.beside + prior_of(0.0)
    odds += evidence.beside + prior
    refusal = _too_few(evidence, len(cloud.working), question.only)
    if not refusal and (refusal := _several(evidence, len(cloud.working))):
        foreign = max(foreign, odds)
    settled = evidence.exact_share > 0.5 and not evidence.on_curves
    found = Claim(evidence, prior, refusal, settled, odds, foreign, _words(evidence))
    if question.max_error is not None:
        mean = mean_error if question.counts_all else evidence.mean_inlier_distance / cloud.diagonal
        return _by_threshold(found, mean, question.max_error, question.counts_all)
    if question.only and question.counts_all:
        return _as_told(found, question.tolerance)
    scattered = evidence.noise_scale > 2.0 * SCATTER * cloud.extent
    if 0.0 < evidence.exact_share <= PART and scattered and not refusal:
        return replace(found, refusal=_volume(found.words))
    return found


def _by_threshold(found: Claim, mean: float, max_error: float, counts_all: bool) -> Claim:
    """The claim as the caller's threshold has it: within it nothing else is asked."""
    within, cloud = mean <= max_error, found.evidence.cloud
    distance, share = cloud.frame.told(mean * cloud.diagonal), unlike(mean, max_error)[0]
    words = (
        f"the points lie {distance} from the {found.kind} on average; that is {share} of the diagonal of "
        f"their bounding box, {'within' if within else 'over'} max_error ({as_given(max_error)})"
    )
    refusal = ("" if counts_all else found.refusal) or ("" if within else words)
    return replace(found, refusal=refusal, settled=within, foreign=-np.inf, words=words)


def _as_told(found: Claim, tolerance: float) -> Claim:
    """The claim of the only kind allowed, by every point: however it fits, the caller knows what it is."""
    words = found.words
    if found.refusal or found.foreign > found.odds:
        why = found.refusal or _off(found.evidence.explained, found.evidence, tolerance)
        words = f"{why}; the {found.kind} is answered as the only kind allowed"
    return replace(found, refusal="", settled=True, foreign=-np.inf, words=words)


def _too_few(evidence: Evidence, n_points: int, only: bool) -> str:
    """Why the points are too few to tell, or nothing."""
    kind = evidence.primitive.kind
    if only:
        return ""
    if n_points == evidence.free:
        return f"{n_points} points determine a {kind} and leave none to check it with"
    if not evidence.exact.any() and n_points < 2 * evidence.free:
        least = f"{2 * evidence.free} are needed where they do not lie on it exactly"
        return f"{n_points} points are too few to check a {kind} with: {least}"
    return ""


def _several(evidence: Evidence, n_points: int) -> str:
    """Why the cloud is more than this surface, or nothing."""
    kind, share = evidence.primitive.kind, evidence.inlier_share
    least = min(PART + evidence.free / n_points, 1.0)
    if share < least:
        near, needed = unlike(share, least, percent)
        return f"only {near} of the points lie near the {kind}, and at least {needed} must"
    second = evidence.second_surface
    if second > PART:
        far, most = unlike(second, PART, percent)
        return f"{far} of the points form a second surface, away from the {kind}, and at most {most} may"
    return ""


def _words(evidence: Evidence) -> str:
    """What the points are like about the surface, in input units."""
    cloud, kind = evidence.cloud, evidence.primitive.kind
    if evidence.exact.all():
        return f"every point lies on the {kind} within the rounding of the coordinates"
    scatter = f"scatter by {cloud.frame.told(evidence.noise_scale)} about"
    if evidence.exact.any():
        return (
            f"{part(evidence.exact_share)} of the points lie on the {kind} exactly; the others {scatter} it"
        )
    explained = evidence.explained
    if explained is None:
        return f"the points {scatter} the {kind}"
    best = explained.likeliest
    patterns = []
    if explained.rough[best] > 0.0:
        size = cloud.frame.told(explained.rough[best])
        span = cloud.frame.told(cloud.extent * explained.rough_range[best])
        patterns.append(f"neighbors share a deviation of {size} over {span}")
    if explained.smooth[best] > 0.0:
        patterns.append(f"they deviate smoothly from it {_smooth(explained, best, cloud)}")
    if not patterns:
        return f"the points {scatter} the {kind} and show no pattern"
    return f"the points {scatter} the {kind}; {', and '.join(patterns)}"


def _smooth(explained: Explanations, which: int, cloud: Cloud) -> str:
    """The size and range of a smooth deviation, and how large it is beside the noise of a point."""
    told, ratio = cloud.frame.told, explained.smooth[which] / explained.white[which]
    span = told(cloud.extent * explained.smooth_range[which])
    return f"by {told(explained.smooth[which])} over {span}, {digits(ratio, 2)} times their noise"


def likelier(a: Claim, b: Claim) -> bool:
    """Whether `a` is the better claim: more exact points, of equal shares the simpler kind; else its odds."""
    one, other = a.evidence, b.evidence
    if not (one.exact.any() or other.exact.any()):
        return a.odds > b.odds
    if abs(one.exact_share - other.exact_share) <= EQUAL_SHARES * max(one.exact_share, other.exact_share):
        return a.dof < b.dof
    if one.exact_share > other.exact_share:
        return _moved_off(one, other)
    return not _moved_off(other, one)


def _moved_off(exact: Evidence, other: Evidence) -> bool:
    """Whether the points beside the exact ones of a surface may have been moved off it.

    Then they are not twice as near to another surface as to it, unless they are the smaller part and of
    another. A ring of a spinning laser, whose noise is along the ray, lies exactly on a cone about the laser,
    whatever it was seen on; every lattice has planes.
    """
    if exact.exact_share > 0.5:
        return True
    near, nearer = (np.median(np.abs(each.distance[~exact.exact])) for each in (exact, other))
    return bool(near <= 2.0 * nearer)


def best_of(claims: list[Claim]) -> Claim:
    best = claims[0]
    for each in claims[1:]:
        if likelier(each, best):
            best = each
    return best


def decide(claims: list[Claim], tolerance: float) -> Decision:
    """From at least one claim: the likeliest kind, those that are about as likely, or none of them."""
    possible = [each for each in claims if not each.refusal]
    if not possible:
        best = max(claims, key=lambda each: each.standing)
        return Decision("no_fit", best, (), best.refusal, best)
    likeliest = best_of(possible)
    foreign, why, about = _foreign(likeliest, claims, tolerance)
    if foreign > likeliest.odds:
        return Decision("no_fit", likeliest, (), why, about)
    same = _the_same(likeliest, possible, tolerance)
    best = min(same, key=lambda each: each.dof, default=likeliest)
    others = sorted(
        (each for each in possible if each not in (likeliest, *same)), key=lambda each: -each.odds
    )
    rivals = tuple(each for each in others if _as_likely(each, likeliest))
    return Decision("ambiguous" if rivals else "fitted", best, rivals, best.words, best)


def _the_same(likeliest: Claim, possible: list[Claim], tolerance: float) -> list[Claim]:
    """Those that agree with it within a tolerance, where the points tell surfaces apart."""
    if not tolerance or likeliest.evidence.on_curves:
        return []
    return [each for each in possible if _agree(each, likeliest, tolerance)]


def _as_likely(other: Claim, best: Claim) -> bool:
    """Whether a claim that is no better than the best one is not told from it.

    Where points lie on curves, the surface that has the fewest parameters is no likelier for that.
    """
    one, two = best.evidence, other.evidence
    if one.on_curves:
        if one.exact.any():
            return abs(one.exact_share - two.exact_share) <= EQUAL_SHARES * one.exact_share
        return not two.exact.any() and one.noise.log_likelihood - two.noise.log_likelihood < DECIDED
    return not (one.exact.any() or two.exact.any()) and best.odds - other.odds < DECIDED


def _foreign(best: Claim, claims: list[Claim], tolerance: float) -> tuple[float, str, Claim]:
    """How likely it is that none of the kinds is right, in the unit of the odds of the best claim, and why.

    Why is a clause about the surface of the claim that comes third.

    Beside what each kind's patches say of another shape near it, whether the points deviate smoothly from the
    best kind as a function of one of its coordinates alone.
    """
    if best.settled or best.evidence.exact.any():
        return -np.inf, "", best
    other = max(claims, key=lambda each: each.foreign)
    about = best if best.foreign > best.odds else other
    why = about.refusal or _off(about.evidence.explained, about.evidence, tolerance)
    along = ((odds, said, best) for odds, said in _foreign_along(best, tolerance))
    return max([(other.foreign, why, about), *along], key=lambda found: found[0])


def _foreign_along(best: Claim, tolerance: float) -> list[tuple[float, str]]:
    """The same by each of its coordinates alone."""
    found = []
    for explained in best.evidence.along_its_own:
        mask = bearable(explained, best.evidence, tolerance)
        odds = best.odds - best.prior + prior_of(0.0) + explained.among(~mask) - explained.among(mask)
        found.append((odds, _off(explained, best.evidence, tolerance)))
    return found


def _off(explained: Explanations | None, evidence: Evidence, tolerance: float) -> str:
    """What is wrong with a surface, by the likeliest explanation that its kind does not bear."""
    if explained is None:
        return _words(evidence)
    kind, cloud = evidence.primitive.kind, evidence.cloud
    wrong = ~bearable(explained, evidence, tolerance)
    worst = int(np.argmax(np.where(wrong, explained.log_evidence, -np.inf)))
    white = explained.white[worst]
    if explained.smooth[worst] > max(white, FORM * cloud.extent):
        deviation = f"smoothly {_smooth(explained, worst, cloud)}"
        return f"the points deviate systematically from the {kind}, {deviation}"
    if explained.hidden > 2.0 * white:
        deviation = f"by {cloud.frame.told(explained.hidden)} within short distances"
        return f"the points deviate systematically from the {kind}, {deviation}"
    scatter = cloud.frame.told(evidence.noise_scale)
    return _volume(f"the points scatter by {scatter} about the {kind}")


def _volume(said: str) -> str:
    """What is said about points, and that so much scatter is no surface."""
    return f"{said}: they fill a volume, or lie on several surfaces"


def may_overtake(
    kind: str, probability: float, best: Claim, tolerance: float, apart: Callable[[str], float]
) -> bool:
    """Whether an untried kind might be as likely as the best claim.

    It leaves over white noise at best, and each parameter costs what it costs the best kind; it may always be
    as good as the best one, as the points might lie on it exactly. What must be overtaken is another shape
    near the best kind where that is likelier. Where all that the points may be of is near the best surface,
    kinds that have it for a limit are asked by what they would gain to first order, and twice the odds that
    tell two kinds are left for what that neglects. Others must come near it, as simpler kinds must anyway, or
    their deviation would be that of another shape: `apart` tells how far their nearest surface is from it.
    """
    if best.settled:
        return False
    if best.evidence.on_curves:
        return True
    known = prior_of(probability) - (best.prior if best.odds >= best.foreign else prior_of(0.0))
    if best.evidence.exact.any():
        return known > -DECIDED
    cloud, explained = best.evidence.cloud, best.evidence.explained
    more = PRIMITIVES[kind].dof - best.dof
    if explained is not None and explained.unexplained is not None:
        if max(explained.unexplained - more * _cost(best), 0.0) + known <= -DECIDED:
            return False
    near = more < 0 or _has_all_near(best, tolerance)
    if more > 0 and near and (gain := _gain(kind, best, tolerance)) is not None:
        return gain + known > -2.0 * DECIDED
    limit = max(best.evidence.noise_scale, FORM * cloud.extent, tolerance)
    return not near or apart(kind) <= 2.0 * limit


def _has_all_near(best: Claim, tolerance: float) -> bool:
    """Whether whatever else the points may be of is near the best surface.

    So few are rejected that they may be another's, noise is well below that of a volume, and nothing says
    that it is another shape.
    """
    evidence = best.evidence
    if evidence.explained is None or evidence.trial.limits is not None or best.odds < best.foreign:
        return False
    few_rejected = evidence.inlier_share >= 1.0 - PART
    near = evidence.noise_scale <= 0.5 * SCATTER * evidence.cloud.extent
    return few_rejected and near and all(odds <= best.odds for odds, _ in _foreign_along(best, tolerance))


def _cost(best: Claim) -> float:
    """Of a parameter more: how much less likely it makes all values but the right one."""
    evidence, explained = best.evidence, best.evidence.explained
    assert explained is not None
    spread = PRIOR * evidence.cloud.extent * np.sqrt(np.count_nonzero(evidence.inlier))
    return float(np.log(np.hypot(1.0, spread / explained.white[explained.likeliest])))


def _gain(kind: str, best: Claim, tolerance: float) -> float | None:
    """By how much surfaces of a kind near the best one are likelier, to first order, before any ranking.

    None where they do not have it for a limit. Ways to leave it beyond the kind's parameters cost nothing.
    """
    evidence = best.evidence
    for kinds, count, explained in evidence.bent:
        if kind in kinds:
            spare = count - (PRIMITIVES[kind].dof - best.dof)
            odds = explained.among(bearable(explained, evidence, tolerance)) + evidence.beside
            return odds + spare * _cost(best) - (best.odds - best.prior)
    return None


def _agree(one: Claim, other: Claim, tolerance: float) -> bool:
    """Whether two surfaces are within the tolerance of each other where the cloud is."""
    surface, cloud = one.evidence.primitive, one.evidence.cloud
    points: Array = cloud.working[cloud.sample[one.evidence.inlier[cloud.sample]]]
    feet = points - surface.signed_distance(points)[:, None] * surface.gradient(points)
    return bool(np.all(np.abs(other.evidence.primitive.signed_distance(feet)) <= tolerance))
