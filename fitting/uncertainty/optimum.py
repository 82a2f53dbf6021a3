"""An answer as the optimum that it is: which points it minimizes what over, and which steps are free."""

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Self

import numpy as np

from ..cloud.cloud import WORKING_POINTS, Cloud
from ..geometry.vectors import Array
from ..noise.kernels import Kernel
from ..noise.rounding import ROUNDING_NOISE
from ..noise.student import half_interval
from ..primitives import DIRECTIONS, PRIMITIVES, SIZES, is_angle, is_length, names_of
from ..primitives.primitive import Primitive
from ..request.constraints import TOUCHES
from ..search.finished import Finished
from ..solver.refine import CODES
from ..trial.limits import Limits, moved
from ..trial.trial import Trial
from ..verdict.evidence import Evidence
from . import _profile
from .agreement import Agreement
from .covariance import Cost, Linear, StepCovariance

UNEVEN = 200
"""Points from which noise that differs from point to point, or agrees between neighbors, can be told."""


@dataclass(frozen=True, eq=False)
class Layout:
    """Of the P numbers of a kind.

    Attributes
    ----------
    names : (P,) of them
    lengths : (P,) mask of those that carry the unit of the points
    sizes : indices of radii and half-angles
    positions : the first index of each point, which has three coordinates
    direction : the first index of the axis or normal, or None
    places, angles : in the row of a surface, of its sizes, and which of these are angles
    """

    names: tuple[str, ...]
    lengths: np.ndarray
    sizes: tuple[int, ...]
    positions: tuple[int, ...]
    direction: int | None
    places: tuple[int, ...]
    angles: tuple[bool, ...]

    @classmethod
    @cache
    def of(cls, kind: str) -> Self:
        names, numbers = names_of(kind), PRIMITIVES[kind].chart.numbers
        firsts = {name.split(".")[0]: i for i, name in reversed(list(enumerate(names)))}
        directions = [i for name, i in firsts.items() if name in DIRECTIONS]
        return cls(
            names,
            np.array([is_length(name) for name in names]),
            tuple(i for i, name in enumerate(names) if name in SIZES),
            tuple(sorted(i for name, i in firsts.items() if name not in (*SIZES, *DIRECTIONS))),
            min(directions, default=None),
            tuple(place for _, place in numbers.values()),
            tuple(is_angle(name) for name in numbers),
        )

    @property
    def vectors(self) -> list[slice]:
        """Of the numbers of each point and size, in their order."""
        starts = {first: slice(first, first + 3) for first in self.positions}
        starts |= {size: slice(size, size + 1) for size in self.sizes}
        return [starts[first] for first in sorted(starts)]


@dataclass(frozen=True, eq=False)
class Optimum:
    """A surface in the frame of its steps, whose origin is that of the cloud or a fixed position.

    Attributes
    ----------
    primitive, row : in its canonical sign, and the nine numbers that steps change
    trial : kind, cloud and limits
    cost : what it minimizes, over working points or the exact ones among them
    inlier : mask of those points that were not rejected
    exact : the points lie on it within their rounding
    agreement : of the noise of its points, None where it was not looked for
    full, linear : the linearized cost in all directions, and in those that no limit holds
    """

    primitive: Primitive
    row: Array
    trial: Trial
    cost: Cost
    inlier: np.ndarray
    exact: bool
    agreement: Agreement | None
    full: Linear
    linear: Linear

    @classmethod
    def of(cls, finished: Finished, evidence: Evidence) -> Self:
        """From where a criterion ended (in the frame of the cloud), and the evidence about the robust fit."""
        assert finished.kernel is not None
        trial, cloud, limits = evidence.trial, evidence.cloud, evidence.trial.limits
        primitive, points = finished.primitive.canonical(np.zeros(3)), cloud.working
        if limits is not None:
            primitive, points = moved(primitive, -limits.pivot), points - limits.pivot
        exact = bool(evidence.exact.all() or (finished.exact and evidence.exact.any()))
        kernel, scale = finished.kernel, finished.scale
        factors, inlier = cloud.working_factors, evidence.inlier
        if exact:
            kernel, scale = Kernel.LEAST_SQUARES, 1.0
            factors = None if factors is None else factors[evidence.exact]
            points, inlier = points[evidence.exact], inlier[evidence.exact]
        cost = Cost(points, kernel, scale, factors)
        n = len(cloud.points)
        copies = n / len(cloud.working) if n > WORKING_POINTS and not exact else 1.0
        row = primitive.row()
        full = Linear.of(primitive.kind, row, cost, copies)
        linear = full if limits is None else full.within(limits.free_steps(row))
        agreement = None if exact else _agreement(evidence)
        return cls(primitive, row, trial, cost, inlier, exact, agreement, full, linear)

    @property
    def cloud(self) -> Cloud:
        return self.trial.cloud

    @property
    def limits(self) -> Limits | None:
        return self.trial.limits

    @property
    def copies(self) -> float:
        """How many points each of those that are looked at stands for."""
        return self.full.copies

    @property
    def dof(self) -> int:
        return self.linear.steps

    def covariance(self, linear: Linear) -> StepCovariance | None:
        """Of a step: of the rounding, of noise that is the same everywhere where points are few, else of
        uneven noise. None where nothing is left to estimate the noise from."""
        if len(self.cloud.working) <= linear.steps:
            return None
        if self.exact:
            return linear.known(ROUNDING_NOISE * self.cloud.tolerance)
        few = len(self.cost.points) < UNEVEN
        return linear.equal(self.inlier) if few else linear.uneven(self.agreement)

    def released(self, name: str) -> StepCovariance | None:
        """The same if the number of this name were free."""
        if self.limits is None:
            return None
        free = self.limits.releasing(name).free_steps(self.row)
        return self.covariance(self.full.within(free))

    def quantile(self, steps: StepCovariance) -> float:
        """Half of a 95% interval in standard deviations: Student's t, as the noise is estimated."""
        return half_interval(None if self.exact else max(steps.estimates - self.dof, 1.0))

    @property
    def layout(self) -> Layout:
        """Which of its numbers is what."""
        return Layout.of(self.primitive.kind)

    @cached_property
    def units(self) -> Array:
        """What the numbers (P,) of the answer are measured in, over their units in the frame."""
        return np.where(self.layout.lengths, self.cloud.frame.scale, 1.0)

    @cached_property
    def center(self) -> Array:
        """(3,) where the cloud has its origin, in the frame of the steps."""
        return np.zeros(3) if self.limits is None else -self.limits.pivot

    @cached_property
    def numbers(self) -> tuple[Array, Array]:
        """The numbers (P,) and their derivatives (P, dof) by a step, in the frame of the steps."""
        return _profile.numbers(CODES[self.primitive.kind], self.row, self.center)

    @property
    def by_step(self) -> Array:
        """Derivatives (P, dof) of the numbers of the answer, in input units, by a step."""
        return self.units[:, None] * self.numbers[1]

    def region(self) -> _profile.Region:
        """The surfaces about it."""
        cost, limits = self.cost, self.limits
        return _profile.Region(
            CODES[self.primitive.kind],
            self.row,
            cost.points,
            kernel=cost.kernel,
            scale=cost.scale,
            factors=cost.factors,
            bounds=None if limits is None else limits.bounds,
            touches=TOUCHES,
            center=self.center,
            sizes=self.layout.places,
            angles=self.layout.angles,
        )

    def given(self, values: Array) -> Array:
        """Numbers (P,) in the frame of the steps as those of an answer, in input units."""
        found = self.units * values
        for first in self.layout.positions:
            found[first : first + 3] += self.cloud.frame.center - self.cloud.frame.scale * self.center
        return found


def _agreement(evidence: Evidence) -> Agreement | None:
    """Of the distances of the inliers; their variance is that of normal noise; None without any."""
    if evidence.explained is None:
        return None
    cloud, left = evidence.cloud, evidence.distance[evidence.inlier]
    variance = float(left @ left) / max(len(left) - evidence.free, 1)
    if variance == 0.0:  # as many inliers as determine the surface
        return None
    return Agreement.of(evidence.explained, cloud.patch, evidence.inlier, cloud.extent, variance)
