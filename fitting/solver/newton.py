"""The last digits of an optimum, by Newton's method on the gradient of the cost.

Levenberg-Marquardt judges a step by the cost, in which a step of 1e-8 uncertainties does not show, and comes
nearer by a constant factor only where residuals are large beside the radii of curvature.
"""

import numpy as np

from ..geometry.vectors import Array
from ..noise.kernels import Kernel
from ..primitives.primitive import Primitive
from . import _newton
from .refine import CODES


def newton(primitive: Primitive, points: Array, kernel: Kernel, scale: float = 1.0) -> Primitive:
    """The stationary point of  sum rho(d / scale)  that the primitive is close to.

    The primitive itself comes back where it is near no minimum.
    """
    row = _newton.newton(
        CODES[primitive.kind],
        primitive.row(),
        np.ascontiguousarray(points),
        kernel,
        scale,
        primitive.chart.across,
    )
    return primitive if row is None else type(primitive).from_row(row)
