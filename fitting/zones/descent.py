"""The way down: steps that lower the largest value over some points, to a minimum that is proven or to none.

Source: sequential linear programming with Newton steps on the active points and second-order corrections,
Fletcher and Sainz de la Maza, "Nonlinear programming and nonsmooth optimization by successive linear
programming", Mathematical Programming 43, 1989. An end is a local minimum that a last linear program
confirms, or a failure.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ..cloud.cloud import Cloud
from ..errors import FailedFit
from ..geometry.vectors import TINY, Array
from ..primitives.primitive import Primitive
from ..solver.refine import bent, stepped
from .program import SLACK, Linear, linear_program
from .task import MAXIMUM_INSCRIBED, Task

LARGEST_TURN = 0.11
"""By what angle [rad] the normals of what passes for a plane may turn over its length."""

STEPS = 80
"""Accepted and refused steps after which a start is given up."""

AT_REST = 1e-15
"""A step that promises less, in the normalized frame, is not worth taking."""

SMALLEST_REGION = 1e-16
"""At this radius of the trust region nothing can be gained any more."""

NEARBY, PROVEN = 0.01, 1e-6
"""A minimum is one if no step that changes values by this share of the largest, in the root mean square,
promises to lower that by more than this share."""

ROUNDED, LARGEST_ROUNDING = 64.0, 1e-11
"""A largest distance of less than so many roundings, if these are less than this in the normalized frame, is
none. Rounding grows with the numbers of a surface: near a plane, the distances of a sphere drown in it."""

WEAKEST = 1e-11
"""Relative size below which rounding hides a direction that the points hardly determine: it is not stretched
any further, and nothing is proven about it."""

FOLLOWED, STRAIGHT = 4, 1e-3
"""Moves tried for one step, and the share of it that values may be off what it promised, in the root mean
square, without another one."""

GOOD, GROWTH, SHRINKAGE = 0.5, 2.0, 0.25
"""A step that gains more than the first share of what it promised lets the trust region grow to so many of
its lengths; another one shrinks it."""

DIFFERENCE, LEAST_WIDTH = 1e-3, 1e-7
"""Width of differences for second derivatives, in spreads of the values, and its least, in the frame."""

SMALLEST_SPREAD = 0.01
"""Centers and axes start with a trust region of at least this share of the extent."""

TRUSTED = 1e-6
"""A Newton step below this that gains nothing is taken for the last one: what it gains drowns in rounding."""

REACH = 4.0
"""Newton's step is cut to so many radii of the trust region."""

ACTIVE_CHANGES = 20
"""Points that may enter or leave the active set within one Newton step."""


@dataclass(frozen=True)
class End:
    """Where the steps end, and whether the last linear program proves that to be a minimum."""

    primitive: Primitive
    is_proven: bool

    def proven(self, what: str, cloud: Cloud) -> Primitive | FailedFit:
        """The minimum, or why there is none; `what` names it."""
        if self.is_proven:
            return self.primitive
        kind, limit = self.primitive.kind, self._limit(cloud)
        why = f": where the points are it is hardly different from a {limit}" if limit else ""
        return FailedFit(f"the search for the {what} of a {kind} did not converge{why}")

    def _limit(self, cloud: Cloud) -> str:
        """The simpler kind that the surface almost is where the points are, or nothing."""
        normals = self.primitive.gradient(cloud.points)
        if np.linalg.norm(normals - normals.mean(axis=0), axis=1).max() < LARGEST_TURN:
            return "plane"
        return " or a ".join(self.primitive.simpler_kinds(cloud.extent))


@dataclass(frozen=True)
class Place:
    """A surface on the way, linearized.

    Attributes
    ----------
    task, primitive, points : what is made small, of which surface, over which points (N, 3)
    values : g (M,)
    slopes : (M, k) derivatives of the values in coordinates in which a unit step changes them by 1 in the
        root mean square
    whitening : (k, k) from these coordinates to those of `Task.slopes`
    is_determined : whether rounding hides no direction
    """

    task: Task
    primitive: Primitive
    points: Array
    values: Array
    slopes: Array
    whitening: Array
    is_determined: bool

    @classmethod
    def at(cls, task: Task, primitive: Primitive, points: Array, values: Array) -> Self:
        slopes = task.slopes(primitive, primitive, points)
        triangle = np.linalg.qr(slopes, mode="r") / np.sqrt(len(slopes))
        lengths = np.linalg.norm(triangle, axis=0) + TINY
        _, sizes, vectors = np.linalg.svd(triangle / lengths)
        weakest = WEAKEST * sizes[0]
        whitening = vectors.T / np.maximum(sizes, weakest) / lengths[:, None]
        return cls(task, primitive, points, values, slopes @ whitening, whitening, bool(sizes[-1] > weakest))

    @property
    def worst(self) -> float:
        return float(self.values.max())

    def followed(self, step: Array) -> tuple[Primitive, Array]:
        """The surface after a step (k,), and its values: of a few moves the one whose largest value is least.

        Each move corrects the one before by what the values are off, as far as a step can undo that: so they
        change by what the step promises even where the coordinates are strongly curved.
        """
        wanted = self.values + self.slopes @ step
        accepted = STRAIGHT * float(np.linalg.norm(step))
        best: tuple[Primitive, Array] | None = None
        for _ in range(FOLLOWED):
            move = bent(self.primitive, self.task.padded(self.whitening @ step))
            values = self.task.values(move, self.points)
            if best is None or values.max() < best[1].max():
                best = move, values
            correction = self.slopes.T @ (values - wanted) / len(values)
            if not np.linalg.norm(correction) > accepted:
                break
            step = step - correction
        assert best is not None
        return best


def descend(task: Task, start: Primitive, points: Array, cloud: Cloud) -> End:
    """Where the largest value over some points (N, 3) of a cloud has a local minimum, if that is reached.

    Every step solves the linear program in a trust region and takes a Newton step on the points that are
    active there. Where neither gains what was promised, the program is solved once more with the values
    that the surfaces' curvature brought about, a second-order correction. The step that gains most is taken.
    """
    primitive, values = start, task.values(start, points)
    region = max(float(np.ptp(values)), SMALLEST_SPREAD * cloud.extent if task.radial else cloud.tolerance)
    for _ in range(STEPS):
        place = Place.at(task, primitive, points, values)
        if not np.isfinite(place.slopes).all() or (task is MAXIMUM_INSCRIBED and -place.worst > cloud.extent):
            return End(primitive, False)
        linear = linear_program(values, place.slopes, region)
        if linear is None:
            return End(primitive, False)
        if linear.promised <= AT_REST or region <= SMALLEST_REGION:
            break
        newton = linear.step if linear.is_vertex else _newton_step(place, linear)
        steps, ends = _tried(place, linear, newton, region)
        best = int(np.argmin([end[1].max() for end in ends]))
        gain, length = place.worst - float(ends[best][1].max()), float(np.abs(steps[best]).max())
        if not gain > 0.0:
            if np.abs(newton).max() <= TRUSTED and ends[0][1].max() <= place.worst + AT_REST:
                primitive, values = ends[0]
                break
            region *= SHRINKAGE
            continue
        good = gain > GOOD * linear.promised
        kept = region if good else SHRINKAGE * region
        is_newton = best == 0 and not linear.is_vertex
        region = max(kept, GROWTH * length) if good or is_newton else kept
        primitive, values = ends[best]
    place = Place.at(task, primitive, points, values)
    return End(_with_radius(task, primitive, place.worst), _is_minimum(place))


def _tried(
    place: Place, linear: Linear, newton: Array, region: float
) -> tuple[list[Array], list[tuple[Primitive, Array]]]:
    """The steps (k,) that are tried, Newton's first, and where each leads, with the values there."""
    curved = newton * min(1.0, REACH * region / max(float(np.abs(newton).max()), region))
    steps = [linear.step] if linear.is_vertex else [curved, linear.step]
    ends = [place.followed(step) for step in steps]
    if place.worst - min(float(end[1].max()) for end in ends) <= GOOD * linear.promised:
        seen = ends[-1][1] - place.slopes @ linear.step
        again = linear_program(seen, place.slopes, region)
        if again is not None:
            steps.append(again.step)
            ends.append(place.followed(again.step))
    return steps, ends


def _is_minimum(place: Place) -> bool:
    """Whether the linear program promises next to nothing any more; see `PROVEN`."""
    size = abs(place.worst)
    rounding = float(np.finfo(np.float64).eps) * max(1.0, float(np.abs(place.primitive.row()).max()))
    if not place.task.radial and size <= ROUNDED * rounding <= LARGEST_ROUNDING:
        return True
    if rounding > PROVEN * size or not place.is_determined:
        return False
    linear = linear_program(place.values, place.slopes, NEARBY * size)
    return linear is not None and linear.promised <= PROVEN * size


def _with_radius(task: Task, primitive: Primitive, worst: float) -> Primitive:
    """The surface, with the radius that the values are about where that was left out."""
    if not task.radial:
        return primitive
    step = np.zeros(primitive.dof)
    step[-1] = abs(worst) - primitive.row()[8]
    return stepped(primitive, step)


def _newton_step(place: Place, linear: Linear) -> Array:
    """The step (k,) to where the active values are equal and stationary, by their second derivatives.

    Values leave the active set where their multiplier is negative, and others enter that would exceed them.
    """
    hessian, values, slopes = _hessian(place, linear), place.values, place.slopes
    k, active = len(hessian), list(linear.active)
    step = np.zeros(k)
    for _ in range(ACTIVE_CHANGES):
        m = len(active)
        system = np.zeros((k + 1 + m, k + 1 + m))
        system[:k, :k] = hessian
        system[k + 1 :, :k], system[:k, k + 1 :] = slopes[active], slopes[active].T
        system[k + 1 :, k] = system[k, k + 1 :] = -1.0
        right = np.concatenate([np.zeros(k), [-1.0], -values[active]])
        solution = np.linalg.lstsq(system, right, rcond=1e-14)[0]
        step, level, multipliers = solution[:k], solution[k], solution[k + 1 :]
        excess = values + slopes @ step - level
        excess[active] = 0.0
        if multipliers.min() < -SLACK and m > 1:
            active.pop(int(np.argmin(multipliers)))
        elif excess.max() > AT_REST and m <= k:
            active.append(int(np.argmax(excess)))
        else:
            break
    return step


def _hessian(place: Place, linear: Linear) -> Array:
    """Second derivatives (k, k) of the weighted sum of the active values, by central differences."""
    points, whitening = place.points, place.whitening
    which, side = linear.active % len(points), linear.active // len(points)
    there, row = points[which], side * len(which) + np.arange(len(which))

    def gradient(step: Array) -> Array:
        moved = stepped(place.primitive, place.task.padded(whitening @ step))
        return linear.weights @ place.task.slopes(place.primitive, moved, there)[row] @ whitening

    width = max(DIFFERENCE * float(np.ptp(place.values)), LEAST_WIDTH)
    rows = np.array([gradient(step) - gradient(-step) for step in width * np.eye(len(whitening))]) / (
        2.0 * width
    )
    return 0.5 * (rows + rows.T)
