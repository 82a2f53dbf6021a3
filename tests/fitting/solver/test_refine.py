"""Least squares from a start nearby comes to the minimum of another optimizer."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.solver.refine import refine, stepped
from tests.fitting.clouds import EXAMPLES, noisy

examples = pytest.mark.parametrize("primitive", EXAMPLES.values(), ids=EXAMPLES.keys())


@examples
def test_refine_agrees_with_scipy(primitive: Primitive) -> None:
    """The same minimum as `scipy.optimize.least_squares` finds from the truth, on noisy points."""
    points = noisy(primitive, 300, 0.03)
    center = points.mean(axis=0)
    start = primitive.transformed(np.eye(3), -center, 1.0)
    ours = refine(start, points - center)
    theirs = least_squares(
        lambda step: stepped(start, step).signed_distance(points - center),
        np.zeros(primitive.dof),
        xtol=1e-14,
    )
    assert ours.cost <= theirs.cost * (1.0 + 1e-10)
