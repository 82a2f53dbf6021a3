"""Levenberg-Marquardt on signed orthogonal distances, under any kernel, for any primitive.

Source: Levenberg 1944, Marquardt 1963; damping on the scaled diagonal as in More, "The Levenberg-Marquardt
algorithm", 1978. Our own, and compiled, rather than scipy's: a step of three to seven parameters is one small
solve, and the search takes thousands of them a cloud.
"""

from dataclasses import dataclass

import numpy as np

from ..geometry.vectors import Array, basis
from ..noise.kernels import Kernel
from ..primitives import PRIMITIVES
from ..primitives.primitive import Chart, Primitive
from ..trial._limits import Bounds
from . import _descent

CODES = {kind: code for code, kind in enumerate(_descent.NAMES)}
"""The numbers of the kinds in the compiled loops."""

STEPS = 60
LIMITED_STEPS = 500
"""Steps after which refinement ends. Limits that the points contradict leave residuals far beyond the scale
of a kernel, where steps gain little each."""


@dataclass(frozen=True)
class Refined:
    """A refined primitive, its cost  sum rho(d / scale), and whether the steps came to rest."""

    primitive: Primitive
    cost: float
    converged: bool


def refine(
    primitive: Primitive,
    points: Array,
    kernel: Kernel = Kernel.LEAST_SQUARES,
    scale: float = 1.0,
    max_iterations: int | None = None,
    factors: Array | None = None,
    bounds: Bounds | None = None,
) -> Refined:
    """The primitive that minimizes  sum rho(d / scale)  near the given one.

    Parameters
    ----------
    primitive : where to start, in the frame of the points
    points : (N, 3) in a frame centered near the origin, extent near 1
    kernel : plain least squares by default
    scale : residual of one unit, in the unit of the points
    max_iterations : steps that lower the cost; `STEPS` by default, `LIMITED_STEPS` within bounds
    factors : (N,) what each distance d is multiplied by
    bounds : within which to stay, and where the primitive lies already
    """
    kind, points = primitive.kind, np.ascontiguousarray(points)
    if max_iterations is None:
        max_iterations = STEPS if bounds is None else LIMITED_STEPS
    row, cost, converged = _descent.refine(
        CODES[kind],
        primitive.row(),
        points,
        kernel,
        scale,
        max_iterations,
        factors,
        bounds,
    )
    return Refined(PRIMITIVES[kind].from_row(row), cost, converged)


def distances(primitive: Primitive, points: Array) -> Array:
    """Signed distances (N,) as `primitive.signed_distance` has them, compiled."""
    return _descent.distances(CODES[primitive.kind], primitive.row(), np.ascontiguousarray(points))


def linearize(primitive: Primitive, points: Array) -> tuple[Array, Array]:
    """Signed distances (N,) and their derivatives (N, dof) by a step in minimal coordinates.

    The coordinates turn an axis or a normal about the point of the axis or plane that lies closest to the
    origin (a torus about its center), so the points should be centered there. `fitting.solver._descent` names
    them and has the formulas.
    """
    return _descent.derivatives(CODES[primitive.kind], primitive.row(), np.ascontiguousarray(points))


def linearize_along(reference: Primitive, primitive: Primitive, points: Array) -> tuple[Array, Array]:
    """`linearize` with tilts and shifts along the basis of a nearby reference of the same kind.

    The basis of an axis jumps where the axis crosses the plane z = 0; this one does not.
    """
    distance, jacobian = linearize(primitive, points)
    turn_back(jacobian, primitive.chart, reference.row(), primitive.row())
    return distance, jacobian


def turn_back(slopes: Array, chart: Chart, reference: Array, row: Array) -> None:
    """Let slopes (..., dof) at a row (9,) be along the basis of a nearby one of its kind."""
    if chart.across:
        theirs, ours = (np.array(basis(axis)) for axis in (reference[:3], row[:3]))
        turn = ours @ theirs.T
        for first, second in chart.across:
            slopes[..., first : second + 1] = slopes[..., first : second + 1] @ turn


def bent(primitive: Primitive, step: Array) -> Primitive:
    """The surface after a step (dof,) along which curvatures change linearly; else `stepped`.

    To first order they are the same.
    """
    row = primitive.bent_row(step)
    return stepped(primitive, step) if row is None else type(primitive).from_row(row)


def stepped(primitive: Primitive, step: Array) -> Primitive:
    """The surface after a step of shape (dof,) in the coordinates of `linearize`."""
    kind = primitive.kind
    return PRIMITIVES[kind].from_row(
        _descent.stepped(CODES[kind], primitive.row(), np.asarray(step, np.float64))
    )
