"""How well the numbers of an answer are known, as values; `fitting.uncertainty.appraise` makes them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ..equality import ByValue
from ..geometry.vectors import Array
from .warnings import Warning

NoiseModelName = Literal["exact", "independent", "correlated", "unknown"]
Method = Literal["linear", "profile", "held", "bound"]


@dataclass(frozen=True)
class Interval:
    """A 95% interval of one number, in the unit of the input or in radians.

    Attributes
    ----------
    low, high : None where the points do not bound it
    standard_deviation : by linearization
    method : `linear`: symmetric; `profile`: how far the number may go, the others adapting, until the points
        contradict it (the cost rises by as much); `held`: by constraints; `bound`: a constraint is active,
        and the interval reaches from it as far as the points would let it go (one-sided)
    """

    low: float | None
    high: float | None
    standard_deviation: float
    method: Method


@dataclass(frozen=True)
class Spread:
    """How far off a direction (radians), or a position across it (length), may be.

    Attributes
    ----------
    radius_95 : how far off it is at most in 95 of 100 cases; a direction has no sign, so pi / 2 at most
    standard_deviations : in its two principal directions, the larger first; a plane's position has one
    """

    radius_95: float
    standard_deviations: tuple[float, ...]


@dataclass(frozen=True)
class CorrelatedNoise:
    """Noise that neighbors share: its correlation at distance h is `share` times exp(-(h / length)^power).

    Attributes
    ----------
    share : of the variance; the rest is each point's own
    effective_points : points with independent noise that would tell as much
    """

    length: float
    share: float
    power: int
    effective_points: float


@dataclass(frozen=True, eq=False)
class Uncertainty(ByValue):
    """How well the numbers of the primitive are known, in the unit of the input and in radians.

    Attributes
    ----------
    noise_model : `exact`: the rounding of the coordinates is all there is; else the noise is taken for
        `independent` or `correlated`; `unknown` where no points are left to estimate it from
    correlation : None unless the noise is correlated
    parameters : names of the numbers, vectors by component
    covariance : (P, P) of `parameters`; singular, as a direction has length 1 and a `point` is the one
        closest to the centroid. None where the noise is unknown
    intervals : of numbers and coordinates, by name; a direction has `direction` instead
    direction : of the axis or normal
    position : of the axis of a cylinder, or of a plane, across it at its `point`
    warnings : what to beware of, in words
    """

    noise_model: NoiseModelName
    correlation: CorrelatedNoise | None
    parameters: tuple[str, ...]
    covariance: Array | None = field(repr=False)
    intervals: Mapping[str, Interval]
    direction: Spread | None
    position: Spread | None
    warnings: tuple[Warning, ...]
