"""What a caller may ask of the fit."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ..errors import InvalidOptionError
from ..names import ANSWER_PARTS, CRITERIA, CRITERION, KINDS, SEED, UNITS, Criterion, Unit
from ..primitives import PRIMITIVES, parameters, parameters_of
from ..primitives.primitive import Primitive
from ..words import as_given
from .constraints import UNCONSTRAINED, Constraints
from .guess import guess_of
from .nominal import Nominal
from .values import number, positive

EXTREME = ("minimum_zone", "minimum_circumscribed", "maximum_inscribed")
"""Criteria of a few extreme points, which take neither constraints nor weights."""

COUNTING_ALL = ("least_squares", *EXTREME)
"""Criteria by which every point counts, whatever its distance."""

WITH_A_RADIUS = tuple(kind for kind in KINDS if "radius" in parameters_of(kind))
_ONE = {"kinds": "kind", "include": "part"}
FITTING_KINDS = {"minimum_circumscribed": WITH_A_RADIUS, "maximum_inscribed": WITH_A_RADIUS}
"""Kinds that a criterion is defined for, where that is not all of them."""


def takes_no(criterion: str, what: str) -> str:
    """The complaint about constraints or weights beside an extreme criterion."""
    others = ", ".join(name for name in CRITERIA if name not in EXTREME)
    return f"criterion {criterion} takes no {what}; these do: {others}"


@dataclass(frozen=True)
class Config:
    """Options of `recognize`; a value out of range raises `InvalidOptionError`.

    Attributes
    ----------
    kinds : kinds that may be answered, without repetition
    criterion : what the parameters minimize.
        `robust`: outliers rejected, exact where the data is exact. `least_squares`: the squares of all
        distances. `huber`, `tukey`: M-estimators with 95% of its efficiency under normal noise; outliers
        pull by a bounded amount, or not at all. `minimum_zone`: the largest distance.
        `minimum_circumscribed`, `maximum_inscribed`: the radius of a sphere or cylinder with all points
        inside, or its negative with all points outside
    max_error : largest accepted mean absolute distance of the points not rejected as outliers, as a share
        of the bounding-box diagonal, in (0, 1]; None derives the limit from the noise of the cloud
    tolerance : what the caller counts as no deviation [length, input units], or None. Kinds that agree within
        it over the cloud count as equal, and the simplest is answered; a smooth deviation within it never
        refuses a kind
    seed : seed of every random choice, from 0 to 2^63 - 1
    constraints : parameters that are fixed or bounded
    initial_guess : a primitive in input units that joins the starts of its kind
    nominal : what the primitive should be, or None; the answer says how far it deviates
    form_tolerance : largest form error of the inliers allowed [length], or None
    include : which of the parts `extents` and `uncertainty` are computed and answered; the others are None
    unit : one of `UNITS`, which stands beside lengths in words and changes nothing else; None where it is not
        known

    Examples
    --------
    >>> import primfit
    >>> primfit.Config(kinds=("plane", "sphere"), seed=7).criterion
    'robust'
    """

    kinds: tuple[str, ...] = KINDS
    criterion: Criterion = CRITERION
    max_error: float | None = None
    tolerance: float | None = None
    seed: int = SEED
    constraints: Constraints = UNCONSTRAINED
    initial_guess: Primitive | None = None
    include: tuple[str, ...] = ANSWER_PARTS
    nominal: Nominal | None = None
    form_tolerance: float | None = None
    unit: Unit | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "kinds", _names("kinds", self.kinds, KINDS))
        if not self.kinds:
            raise InvalidOptionError(f"kinds is empty; name at least one of {', '.join(KINDS)}", "kinds")
        included = _names("include", self.include, ANSWER_PARTS)
        object.__setattr__(self, "include", tuple(part for part in ANSWER_PARTS if part in included))
        _check_criterion(self.criterion, self.kinds)
        if self.max_error is not None and not 0.0 < number("max_error", self.max_error) <= 1.0:
            raise InvalidOptionError(
                f"max_error is {as_given(self.max_error)}; "
                "it is a share of the bounding-box diagonal in (0, 1]",
                "max_error",
            )
        if self.tolerance is not None:
            positive("tolerance", self.tolerance)
        if self.form_tolerance is not None:
            positive("form_tolerance", self.form_tolerance)
        _check_seed(self.seed)
        _check_constraints(self.constraints, self.kinds, self.criterion)
        if self.initial_guess is not None:
            _check_guess(self.initial_guess, self.kinds)
        if self.unit not in (None, *UNITS):
            raise InvalidOptionError(f"unit is {self.unit!r:.40}; allowed are {', '.join(UNITS)}", "unit")


def _names(field: str, given: object, allowed: tuple[str, ...]) -> tuple[str, ...]:
    """A sequence of names out of those allowed, none of them twice."""
    if isinstance(given, str | Mapping) or not isinstance(given, Iterable):
        raise InvalidOptionError(f"{field} must be a sequence of names out of {', '.join(allowed)}", field)
    names = tuple(given)
    for name in names:
        if name not in allowed:
            raise InvalidOptionError(f"{field} holds {name!r:.40}; allowed are {', '.join(allowed)}", field)
    if len(set(names)) < len(names):
        raise InvalidOptionError(f"{field} names the same {_ONE[field]} twice", field)
    return names


def _check_criterion(criterion: str, kinds: tuple[str, ...]) -> None:
    if criterion not in CRITERIA:
        raise InvalidOptionError(
            f"criterion is {criterion!r:.40}; allowed are {', '.join(CRITERIA)}", "criterion"
        )
    if not set(kinds) & set(FITTING_KINDS.get(criterion, KINDS)):
        raise InvalidOptionError(
            f"criterion {criterion} is for {' or '.join(FITTING_KINDS[criterion])}; "
            f"kinds allows only {', '.join(kinds)}",
            "kinds",
        )


def _check_seed(seed: object) -> None:
    if not isinstance(seed, int | np.integer) or isinstance(seed, bool):
        raise InvalidOptionError(f"seed is {seed!r:.40}, not a whole number", "seed")
    if not 0 <= seed < 2**63:
        raise InvalidOptionError("seed must lie between 0 and 2^63 - 1", "seed")


def _check_constraints(constraints: object, kinds: tuple[str, ...], criterion: str) -> None:
    if not isinstance(constraints, Constraints):
        raise InvalidOptionError(
            f"constraints is {constraints!r:.40}; Constraints.of makes them from plain values", "constraints"
        )
    constraints.check_kinds(kinds)
    if constraints.given and criterion in EXTREME:
        raise InvalidOptionError(takes_no(criterion, "constraints"), "constraints")


def _check_guess(guess: Primitive, kinds: tuple[str, ...]) -> None:
    if type(guess) not in PRIMITIVES.values():
        raise InvalidOptionError(f"initial_guess is {guess!r:.40}, not a primitive", "initial_guess")
    guess_of(parameters(guess))
    if guess.kind not in kinds:
        raise InvalidOptionError(
            f"initial_guess is a {guess.kind}; kinds allows only {', '.join(kinds)}", "initial_guess"
        )
