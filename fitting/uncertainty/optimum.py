"""An answer as the optimum that it is: which points it minimises what over, and which steps are free."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ..cloud.cloud import WORKING_POINTS, Cloud
from ..geometry.vectors import Array
from ..noise.kernels import Kernel
from ..noise.rounding import ROUNDING_NOISE
from ..noise.student import half_interval
from ..primitives import is_length, names_of, values_of
from ..primitives.primitive import Primitive
from ..search.finished import Finished
from ..solver.refine import linearize
from ..trial.limits import Limits, moved
from ..trial.trial import Trial
from ..verdict.evidence import Evidence
from .agreement import Agreement
from .covariance import Linear, StepCovariance
from .profile import Cost

UNEVEN = 200
"""Points from which noise that differs from point to point, or agrees between neighbours, can be told."""


@dataclass(frozen=True, eq=False)
class Optimum:
    """A surface in the frame of its steps, whose origin is that of the cloud or a fixed position.

    Attributes
    ----------
    primitive : in its canonical sign
    trial : kind, cloud and limits
    cost : what it minimises, over working points or the exact ones among them
    inlier : mask of those points that were not rejected
    exact : the points lie on it within their rounding
    agreement : of the noise of its points, None where it was not looked for
    full : the linearised cost in all directions
    """

    primitive: Primitive
    trial: Trial
    cost: Cost
    inlier: np.ndarray
    exact: bool
    agreement: Agreement | None
    full: Linear

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
        cost = Cost(points, kernel, scale, factors, limits)
        n = len(cloud.points)
        copies = n / len(cloud.working) if n > WORKING_POINTS and not exact else 1.0
        linear = Linear.of(primitive, cost, *linearize(primitive, points), copies)
        agreement = None if exact else _agreement(evidence)
        return cls(primitive, trial, cost, inlier, exact, agreement, linear)

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
        return self.linear().rows.shape[1]

    def linear(self) -> Linear:
        return self._linear(self.limits)

    def covariance(self, linear: Linear) -> StepCovariance | None:
        """Of a step: of the rounding, of noise that is the same everywhere where points are few, else of
        uneven noise. None where nothing is left to estimate the noise from."""
        if len(self.cloud.working) <= linear.rows.shape[1]:
            return None
        if self.exact:
            return linear.known(ROUNDING_NOISE * self.cloud.tolerance)
        few = len(self.cost.points) < UNEVEN
        return linear.equal(self.inlier) if few else linear.uneven(self.agreement)

    def released(self, name: str) -> StepCovariance | None:
        """The same if the number of this name were free."""
        return None if self.limits is None else self.covariance(self._linear(self.limits.releasing(name)))

    def quantile(self, steps: StepCovariance) -> float:
        """Half of a 95 % interval in standard deviations: Student's t, as the noise is estimated."""
        return half_interval(None if self.exact else max(steps.estimates - self.dof, 1.0))

    @property
    def units(self) -> Array:
        """What the numbers (P,) of the answer are measured in, over their units in the frame."""
        names = names_of(self.primitive.kind)
        return np.where([is_length(name) for name in names], self.cloud.frame.scale, 1.0)

    def by_step(self) -> Array:
        """Derivatives (P, dof) of the numbers of the answer, in input units, by a step."""
        return self.units[:, None] * self.primitive.derivative(self.center)

    @property
    def center(self) -> Array:
        """(3,) where the cloud has its origin, in the frame of the steps."""
        return np.zeros(3) if self.limits is None else -self.limits.pivot

    def numbers(self, primitive: Primitive) -> Array:
        """The numbers (P,), in input units, of a surface in the frame of the steps."""
        inside = primitive if self.limits is None else moved(primitive, self.limits.pivot)
        return values_of(self.cloud.frame.restore(inside.canonical(np.zeros(3))))

    def _linear(self, limits: Limits | None) -> Linear:
        if limits is None:
            return self.full
        return self.full.within(limits.free_steps(self.primitive.row()))


def _agreement(evidence: Evidence) -> Agreement | None:
    """Of the distances of the inliers; their variance is that of normal noise."""
    if evidence.explained is None:
        return None
    cloud, left = evidence.cloud, evidence.distance[evidence.inlier]
    variance = float(left @ left) / max(len(left) - evidence.free, 1)
    return Agreement.of(evidence.explained, cloud.patch, evidence.inlier, cloud.extent, variance)
