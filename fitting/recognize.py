"""The pipeline: check, normalize, rank, and for each kind guess, refine, weigh, until none can overtake."""

from collections.abc import Callable, Mapping

import numpy as np

from .answer.assembly import Failed, Fitted, Tried, assemble, nothing
from .answer.figures import summarize, summarize_noise
from .answer.result import Attempt, Recognition
from .cloud.cloud import Cloud
from .errors import FailedFit, InvalidPointCloudError
from .geometry.vectors import Array
from .names import KINDS
from .primitives.primitive import Primitive
from .request.config import COUNTING_ALL, EXTREME, Config, takes_no
from .request.reach import check_reach
from .search.kind import fit_kind
from .search.starts import distance_to
from .trial.trial import Trial
from .verdict.classifier import Classifier, FittingClassifier
from .verdict.evidence import Evidence
from .verdict.judge import Question, best_of, claim, decide, may_overtake
from .words import sentences

DEFAULT_CONFIG = Config()

RoughFits = Callable[[str], Primitive | None]


def recognize(
    points: Array,
    config: Config = DEFAULT_CONFIG,
    classifier: Classifier | None = None,
    normals: Array | None = None,
    weights: object = None,
    standard_deviations: object = None,
) -> Recognition:
    """Which primitive the points lie on, with its parameters and the trail of attempts.

    Parameters
    ----------
    points : (N, 3), any unit; N >= 3
    config : what may be answered, and how
    classifier : ranks the kinds; None takes them as equally probable, tries all, and selects
    normals : (N, 3), optional, one a point, any length and sign
    weights : (N,), optional, not negative: what the cost of each point is multiplied by in the last
        refinement; 0 leaves a point out
    standard_deviations : (N,), optional, of the noise of each point, in place of weights

    Raises
    ------
    InvalidPointCloudError : points that cannot be a cloud of any allowed kind, or weights beside a criterion
        of extreme points
    InvalidOptionError : constraints or an initial guess out of all proportion to the cloud

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> primfit.recognize(points, primfit.Config(kinds=("sphere", "plane")))
    <Recognition: fitted, sphere, 300 points>
    """
    _check_criterion(config, weights=weights, standard_deviations=standard_deviations)
    cloud = Cloud.prepare(
        points, normals, np.random.default_rng([config.seed, 0]), weights, standard_deviations, config.unit
    )
    check_reach(config.constraints, config.initial_guess, cloud.frame)
    trials = {kind: Trial.of(kind, cloud, config.constraints) for kind in config.kinds}
    _check_count(trials, config)
    probabilities, rough = _rank(cloud, classifier) if classifier else (None, _nothing)
    queue = _Queue(trials, probabilities, config)
    tries: list[Tried] = []
    while trial := queue.next_after(tries):
        first = None if tries else rough(trial.kind)
        tries.append(_attempt(trial, config, probabilities, first))
    claims = [tried.claim for tried in tries if isinstance(tried, Fitted)]
    found = (
        assemble(decide(claims, _tolerance(config, cloud)), tries, config)
        if claims
        else nothing(tries, len(cloud.points), config)
    )
    return found.with_points(points)


def _check_criterion(config: Config, **per_point: object) -> None:
    """Raise `InvalidPointCloudError` for values of points that the criterion does not take."""
    for field, given in per_point.items():
        if given is not None and config.criterion in EXTREME:
            raise InvalidPointCloudError(takes_no(config.criterion, field), field)


def _check_count(trials: Mapping[str, Trial], config: Config) -> None:
    """Raise `InvalidPointCloudError` where the points determine none of the kinds."""
    n_points = len(next(iter(trials.values())).cloud.points)
    fewest = min(trial.dof for trial in trials.values())
    if n_points < fewest:
        kinds = " or ".join(trials)
        within = " within these constraints" if config.constraints.given else ""
        raise InvalidPointCloudError(f"{n_points} points given; a {kinds}{within} needs at least {fewest}")


def _rank(cloud: Cloud, classifier: Classifier) -> tuple[Mapping[str, float], RoughFits]:
    """Probabilities of all kinds, and rough surfaces of some.

    Kinds that the classifier has not learned have an equal share each.
    """
    seen = cloud.working[cloud.sample[: len(cloud.normals)]], cloud.normals
    rough: RoughFits = _nothing
    if isinstance(classifier, FittingClassifier):
        found, rough = classifier.rank_and_fit(*seen)
    else:
        found = classifier.rank(*seen)
    others = [kind for kind in KINDS if kind not in found]
    if not others:
        return found, rough
    left = 1.0 - len(others) / len(KINDS)
    shares = {kind: left * share for kind, share in found.items()}
    return shares | dict.fromkeys(others, 1.0 / len(KINDS)), rough


def _nothing(kind: str) -> Primitive | None:
    """The rough surfaces of a classifier that fits none."""
    return None


def _tolerance(config: Config, cloud: Cloud) -> float:
    """In the frame of the cloud, 0 for none."""
    return 0.0 if config.tolerance is None else config.tolerance / cloud.frame.scale


class _Queue:
    """The kinds that wait for their trial, the likeliest first."""

    def __init__(
        self, trials: Mapping[str, Trial], probabilities: Mapping[str, float] | None, config: Config
    ) -> None:
        self._trials, self._probabilities, self._config = trials, probabilities, config
        self._order = sorted(trials, key=KINDS.index)
        if probabilities:
            self._order.sort(key=lambda kind: -probabilities[kind])
        self._apart: dict[tuple[str, str], float] = {}

    def next_after(self, tries: list[Tried]) -> Trial | None:
        """The first kind that was not tried and might be the answer, or stand beside it."""
        done = {tried.attempt.kind for tried in tries}
        waiting = [kind for kind in self._order if kind not in done]
        kind = next((kind for kind in waiting if self._is_hopeful(kind, tries)), None)
        return None if kind is None else self._trials[kind]

    def _is_hopeful(self, kind: str, tries: list[Tried]) -> bool:
        claims = [tried.claim for tried in tries if isinstance(tried, Fitted) and not tried.claim.refusal]
        if self._probabilities is None or not claims:
            return True
        best = best_of(claims)
        surface = best.evidence.primitive
        if kind in surface.simpler_kinds(extent=1.0):
            return True

        def apart(kind: str) -> float:
            """How far it is from the best surface; kept for the next question."""
            if (kind, best.kind) not in self._apart:
                rng = np.random.default_rng([self._config.seed, 2, KINDS.index(kind)])
                self._apart[kind, best.kind] = distance_to(self._trials[kind], surface, rng)
            return self._apart[kind, best.kind]

        tolerance = _tolerance(self._config, best.evidence.cloud)
        return may_overtake(kind, self._probabilities[kind], best, tolerance, apart)


def _attempt(
    trial: Trial, config: Config, probabilities: Mapping[str, float] | None, rough: Primitive | None
) -> Tried:
    kind, cloud = trial.kind, trial.cloud
    probability = probabilities[kind] if probabilities else None
    rng = np.random.default_rng([config.seed, 1, KINDS.index(kind)])
    fit = fit_kind(trial, config.criterion, rng, config.initial_guess, rough)
    if isinstance(fit, FailedFit):
        return Failed(Attempt(kind, probability, "failed", sentences(fit.reason), None, None, None))
    evidence = Evidence.weigh(fit.robust, trial)
    error = summarize(fit.finished.primitive, evidence)
    question = Question(
        config.max_error, _tolerance(config, cloud), len(config.kinds) == 1, config.criterion in COUNTING_ALL
    )
    found = claim(evidence, probability, error.relative_mean, question)
    answered = config.constraints.written_into(
        cloud.frame.restore(fit.finished.primitive.canonical(np.zeros(3)))
    )
    attempt = Attempt(
        kind=kind,
        probability=probability,
        outcome="refused" if found.refusal else "accepted",
        reason=found.refusal or found.words,
        primitive=answered,
        error=error,
        noise=summarize_noise(evidence),
    )
    return Fitted(attempt, found, fit.finished, answered, error, fit.unlimited)
