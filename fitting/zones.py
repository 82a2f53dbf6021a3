"""Surfaces by their extreme points: minimum zone, minimum circumscribed, maximum inscribed.

Each of them minimises a largest value,  max_i g_i(surface):  with the signed distance d, and with
rho = d + radius from the centre or axis,

=======================  =========  ===========================
criterion                g          what is varied
=======================  =========  ===========================
minimum zone             d and -d   all coordinates of the kind
minimum circumscribed    rho        all but the radius
maximum inscribed        -rho       all but the radius
=======================  =========  ===========================

Terms as in ISO 14405-1. Source: sequential linear programming with Newton steps on the active points,
Fletcher and Sainz de la Maza, "Nonlinear programming and nonsmooth optimization by successive linear
programming", Mathematical Programming 43, 1989.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from fitting.cloud import Cloud
from fitting.geometry import Array
from fitting.primitives import Primitive
from fitting.refine import linearize_along, stepped
from fitting.result import FailedFit

STEPS = 60
"""Accepted and refused steps after which a start is given up."""

ENTERING = 12
"""Points that enter the linear programme at a time, the most violated first."""

AT_REST = 1e-15
"""A step that promises less, in the normalised frame, is not worth taking."""

SMALLEST_REGION = 1e-16
"""At this radius of the trust region nothing can be gained any more."""

WEAKEST = 1e-6
"""Relative size below which a direction that the points hardly determine is not stretched any further."""

DIFFERENCE, LEAST_WIDTH = 1e-3, 1e-7
"""Width of differences for second derivatives, in spreads of the values, and its least, in the frame."""

SMALLEST_SPREAD = 0.01
"""Centres and axes start with a trust region of at least this share of the diagonal."""

TRUSTED = 1e-6
"""A Newton step below this that gains nothing is taken for the last one: what it gains drowns in rounding."""

REACH = 4.0
"""Newton's step may be so many times as long as the trust region is wide."""

OUT_OF_REACH = 1e6
"""Values that are farther below the largest than this many radii of the trust region count as so far."""

SLACK = 1e-9
"""Violations and multipliers below this are none, in radii of the trust region."""

ACTIVE_CHANGES = 20
"""Points that may enter or leave the active set within one Newton step."""


@dataclass(frozen=True)
class Extreme:
    """Which values g are made small: with these signs, of d, or of rho where the radius is left out."""

    signs: tuple[float, ...]
    radial: bool

    def values(self, primitive: Primitive, points: Array) -> Array:
        """g (S N,) for S signs."""
        distance = primitive.signed_distance(points)
        if self.radial:
            distance = distance + primitive.row()[8]
        return np.concatenate([sign * distance for sign in self.signs])

    def slopes(self, reference: Primitive, primitive: Primitive, points: Array) -> Array:
        """dg (S N, k) by a step in the coordinates of the reference; the k-th is the last but the radius."""
        jacobian = linearize_along(reference, primitive, points)[1]
        jacobian = jacobian[:, :-1] if self.radial else jacobian
        return np.concatenate([sign * jacobian for sign in self.signs])

    def moved(self, primitive: Primitive, step: Array) -> Primitive:
        return stepped(primitive, np.append(step, 0.0) if self.radial else step)


MINIMUM_ZONE = Extreme((1.0, -1.0), radial=False)
MINIMUM_CIRCUMSCRIBED = Extreme((1.0,), radial=True)
MAXIMUM_INSCRIBED = Extreme((-1.0,), radial=True)


def minimum_zone(start: Primitive, cloud: Cloud) -> Primitive | FailedFit:
    """The surface whose largest distance is a local minimum, from where a start leads."""
    end = _descend(MINIMUM_ZONE, start, cloud)
    return end or FailedFit(f"the minimum zone of a {start.kind} did not come to rest in {STEPS} steps")


def minimum_circumscribed(start: Primitive, cloud: Cloud) -> Primitive | FailedFit:
    """The smallest sphere or cylinder near a start that has all points inside.

    For a sphere there is one minimum; for a cylinder the axis is that of a minimum near the start. A start
    whose centre or axis is far from the points is moved to their centroid.
    """
    row = start.row()
    if row[8] > cloud.diagonal:
        row[3:6] = 0.0
        start = type(start).from_row(row)
    end = _descend(MINIMUM_CIRCUMSCRIBED, start, cloud)
    return end or FailedFit(f"the minimum circumscribed {start.kind} did not come to rest in {STEPS} steps")


def maximum_inscribed(start: Primitive, cloud: Cloud) -> Primitive | FailedFit:
    """The largest sphere or cylinder with all points outside and its centre or axis between them.

    There may be several maxima: the start, and the start shifted and tilted to either side by as much as its
    distances spread, lead to some of them, and the largest is taken.
    """
    ends = [end for each in _surroundings(start, cloud) if (end := _descend(MAXIMUM_INSCRIBED, each, cloud))]
    if ends:
        return max(ends, key=lambda end: float(end.row()[8]))
    return FailedFit(
        f"the points do not enclose the {'centre' if start.kind == 'sphere' else 'axis'} of a {start.kind}: "
        "an inscribed one grows without limit, or did not come to rest"
    )


def _surroundings(start: Primitive, cloud: Cloud) -> list[Primitive]:
    spread = float(np.ptp(start.signed_distance(cloud.points)))
    steps = spread * np.vstack([np.zeros(start.dof - 1), np.eye(start.dof - 1), -np.eye(start.dof - 1)])
    return [MAXIMUM_INSCRIBED.moved(start, step) for step in steps]


def _descend(task: Extreme, start: Primitive, cloud: Cloud) -> Primitive | None:
    """The surface at which the largest value has a local minimum, or None where none is reached.

    Every step solves the linear programme in a trust region, takes a Newton step on the points that are
    active there, and goes on with whichever of the two gains more.
    """
    points, primitive = cloud.points, start
    values = task.values(primitive, points)
    region = max(float(np.ptp(values)), SMALLEST_SPREAD * cloud.diagonal if task.radial else cloud.tolerance)
    candidates = np.empty(0, np.intp)
    for _ in range(STEPS):
        worst = float(values.max())
        if task is MAXIMUM_INSCRIBED and -worst > cloud.diagonal:
            return None
        slopes = task.slopes(primitive, primitive, points)
        whitening = _whitening(slopes)
        slopes = slopes @ whitening
        linear = _linear_programme(values, slopes, region, candidates)
        if linear is None:
            return None
        if linear.promised <= AT_REST or region <= SMALLEST_REGION:
            return _with_radius(task, primitive, worst)
        candidates = linear.candidates
        curved = _newton_step(task, primitive, points, values, slopes, whitening, linear)
        steps = [step for step in (curved, linear.step) if np.abs(step).max() <= REACH * region]
        moves = [task.moved(primitive, whitening @ step) for step in steps]
        reached = [task.values(move, points) for move in moves]
        best = int(np.argmin([new.max() for new in reached]))
        gain, length = worst - float(reached[best].max()), float(np.abs(steps[best]).max())
        if gain <= 0.0:
            if np.abs(curved).max() <= TRUSTED and reached[0].max() <= worst + AT_REST:
                return _with_radius(task, moves[0], float(reached[0].max()))
            region *= 0.25
            continue
        good = gain > 0.5 * linear.promised
        kept = region if good else 0.25 * region
        region = max(kept, 2.0 * length) if good or steps[best] is curved else kept
        primitive, values = moves[best], reached[best]
    return None


def _with_radius(task: Extreme, primitive: Primitive, worst: float) -> Primitive:
    """The surface, with the radius that the values are about where that was left out."""
    if not task.radial:
        return primitive
    step = np.zeros(primitive.dof)
    step[-1] = abs(worst) - primitive.row()[8]
    return stepped(primitive, step)


def _whitening(slopes: Array) -> Array:
    """Coordinates (k, k) in which a unit step changes the values by 1 in the root mean square."""
    sizes, vectors = np.linalg.eigh(slopes.T @ slopes / len(slopes))
    return vectors / np.sqrt(np.maximum(sizes, WEAKEST**2 * sizes[-1]))


@dataclass(frozen=True)
class Linear:
    """The solution of a linear programme.

    Attributes
    ----------
    step : (k,)
    promised : what it lowers the largest value by
    active : indices (m,) of the values that are the largest then
    weights : (m,) their multipliers, with sum 1
    candidates : indices of the values that were looked at
    """

    step: Array
    promised: float
    active: NDArray[np.intp]
    weights: Array
    candidates: NDArray[np.intp]


def _linear_programme(
    values: Array, slopes: Array, region: float, candidates: NDArray[np.intp]
) -> Linear | None:
    """Least t with  values + slopes . step <= t  and no component of the step beyond the region.

    It is solved for few of the values, to which those are added that violate the solution, until none does.
    None where the solver finds no solution.
    """
    k, worst = slopes.shape[1], values.max()
    headroom = np.minimum((worst - values) / region, OUT_OF_REACH)
    few = np.union1d(candidates, np.argpartition(headroom, min(ENTERING, len(values) - 1))[:ENTERING])
    for _ in range(STEPS):
        found = linprog(
            np.append(np.zeros(k), 1.0),
            A_ub=np.column_stack([slopes[few], -np.ones(len(few))]),
            b_ub=headroom[few],
            bounds=[(-1.0, 1.0)] * k + [(None, None)],
            method="highs-ds",
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )
        if found.x is None:
            return None
        excess = slopes @ found.x[:k] - headroom - found.x[k]
        excess[few] = 0.0
        entering = np.argpartition(-excess, min(ENTERING, len(values) - 1))[:ENTERING]
        entering = entering[excess[entering] > SLACK]
        if not len(entering):
            break
        few = np.union1d(few, entering)
    weights = -found.ineqlin.marginals
    kept = weights > SLACK
    return Linear(region * found.x[:k], -region * found.x[k], few[kept], weights[kept], few)


def _newton_step(
    task: Extreme,
    primitive: Primitive,
    points: Array,
    values: Array,
    slopes: Array,
    whitening: Array,
    linear: Linear,
) -> Array:
    """The step (k,) to where the active values are equal and stationary, by their second derivatives.

    Values leave the active set where their multiplier is negative, and candidates enter that would exceed the
    others.
    """
    hessian = _hessian(
        task, primitive, points, whitening, linear, max(DIFFERENCE * float(np.ptp(values)), LEAST_WIDTH)
    )
    k, active, near = len(whitening), list(linear.active), linear.candidates
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
        excess = values[near] + slopes[near] @ step - level
        excess[np.isin(near, active)] = 0.0
        if multipliers.min() < -SLACK and m > 1:
            active.pop(int(np.argmin(multipliers)))
        elif excess.max() > AT_REST and m <= k:
            active.append(near[int(np.argmax(excess))])
        else:
            break
    return step


def _hessian(
    task: Extreme, primitive: Primitive, points: Array, whitening: Array, linear: Linear, width: float
) -> Array:
    """Second derivatives (k, k) of the weighted sum of the active values, by central differences."""
    which, side = linear.active % len(points), linear.active // len(points)
    there, place = points[which], side * len(which) + np.arange(len(which))

    def gradient(step: Array) -> Array:
        moved = task.moved(primitive, whitening @ step)
        return linear.weights @ task.slopes(primitive, moved, there)[place] @ whitening

    widths = width * np.eye(len(whitening))
    rows = np.array([gradient(step) - gradient(-step) for step in widths]) / (2.0 * widths[0, 0])
    return 0.5 * (rows + rows.T)
