"""Profiles in NumPy, one step after the other: the reference of `primfit.fitting.uncertainty._profile`.

On short arcs the interval of a radius is not symmetric: much larger ones fit nearly as well, and much
smaller ones do not. An end is the farthest value of the number among all surfaces whose cost has risen by no
more than is asked; steps lead to the farthest point of the quadratic model of the cost.
Source: Venzon and Moolgavkar, "A method for computing profile-likelihood-based confidence intervals", Applied
Statistics 37, 1988.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.primitives import SIZES, is_angle
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.solver.refine import linearize, stepped
from primfit.fitting.trial.limits import Limits

ROUNDS = 24
CLOSE = 0.02
"""An end is found when the rise of the cost is this close to what is asked, relatively, and the next step
moves the number by this share of its linearized half-width at most."""

GROWTH, OVERSHOOT = 2.0, 0.5
"""A step may change a size by this factor, and the cost may pass what is asked by this share of the rise."""

SHORTEST = 1e-3
"""Share of a step below which there is none."""

FLATTEST = 1e-3
"""An end beyond which the curvature is this share of what was found, or an angle that close to its limits, is
not bounded by the points."""

Gradient = Callable[[Primitive], Array]
"""The derivative (dof,) of a number by a step from a surface."""


@dataclass(frozen=True, eq=False)
class Cost:
    """The cost of a surface and what it is a sum over; limits are those that hold anyhow."""

    points: Array
    kernel: Kernel
    scale: float
    factors: Array | None
    limits: Limits | None

    def near(self, primitive: Primitive) -> "Local":
        distance, rows = linearize(primitive, self.points)
        free = None if self.limits is None else self.limits.free_steps(primitive.row())
        if free is not None:
            rows = rows @ free
        if self.factors is not None:
            distance, rows = self.factors * distance, self.factors[:, None] * rows
        rho, weight = self.kernel.rho_and_weight((distance / self.scale) ** 2)
        slope, square = rows.T @ (weight * distance), rows.T @ (weight[:, None] * rows)
        return Local(float(rho.sum()), slope / self.scale**2, square / self.scale**2, free)


@dataclass(frozen=True, eq=False)
class Local:
    """A cost and its quadratic model about a surface, in its k free steps: slope (k,), curvature (k, k)."""

    cost: float
    slope: Array
    square: Array
    free: Array | None

    def farthest(self, gradient: Array, rise: float) -> Array | None:
        """The step (dof,) to where a number with this gradient (dof,) is largest at so much more cost.

        None where the model leaves a step open.
        """
        wanted = gradient if self.free is None else self.free.T @ gradient
        sizes = np.sqrt(np.maximum(self.square.diagonal(), 0.0))
        if not (sizes > 0.0).all():
            return None
        units = sizes[:, None] * sizes
        try:
            inverse = np.linalg.inv(self.square / units) / units
        except np.linalg.LinAlgError:
            return None
        least, along = -inverse @ self.slope, inverse @ wanted
        left = rise - 0.5 * self.slope @ least
        reach = float(wanted @ along)
        if not reach > 0.0:
            return None
        step = least + np.sqrt(2.0 * max(left, 0.0) / reach) * along
        return np.asarray(step if self.free is None else self.free @ step)


def profile_end(
    cost: Cost,
    start: Primitive,
    at_start: Local,
    gradient: Gradient,
    half: float,
    least: float,
    most: float,
) -> tuple[Primitive, Local] | None:
    """The surface where a number is largest among those of at most so much cost; None where none ends it.

    Parameters
    ----------
    cost : what is minimized
    start, at_start : where to begin, with the model of the cost there
    gradient : of the number; with its negative, of the other end
    half : of the linearized interval
    least, most : the cost at the optimum and at the ends
    """
    surface, local, rise = start, at_start, most - least
    for _ in range(ROUNDS):
        direction = gradient(surface)
        step = local.farthest(direction, most - local.cost)
        if step is None:
            return None
        if abs(local.cost - most) <= CLOSE * rise and abs(direction @ step) <= CLOSE * half:
            return surface, local
        moved = _moved(cost, surface, step, max(most, local.cost) + OVERSHOOT * rise)
        if moved is None:
            return None
        surface, local = moved
        if _is_flat(start, surface):
            return None
    return None


def _moved(cost: Cost, surface: Primitive, step: Array, most: float) -> tuple[Primitive, Local] | None:
    """Where the largest of some shares of a step leads that is allowed."""
    share = 1.0
    while share > SHORTEST:
        there = stepped(surface, share * step)
        if all(
            0.0 < old / GROWTH <= new <= old * GROWTH and (not is_angle(name) or new < np.pi / 2)
            for (name, old), (_, new) in zip(_sizes(surface), _sizes(there), strict=True)
        ):
            local = cost.near(there)
            if local.cost <= most:
                return there, local
        share *= 0.5
    return None


def _is_flat(start: Primitive, surface: Primitive) -> bool:
    """Whether a size has gone as far as sizes go."""
    return any(
        not FLATTEST <= new <= np.pi / 2 - FLATTEST if is_angle(name) else new > old / FLATTEST
        for (name, old), (_, new) in zip(_sizes(start), _sizes(surface), strict=True)
    )


def _sizes(primitive: Primitive) -> list[tuple[str, float]]:
    return [(name, float(getattr(primitive, name))) for name in SIZES if hasattr(primitive, name)]
