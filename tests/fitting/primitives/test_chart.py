"""The numbers of a surface: their derivatives are their differences."""

import numpy as np
import pytest

from primfit.fitting.primitives import values_of
from primfit.fitting.solver.refine import CODES, stepped
from primfit.fitting.uncertainty._profile import numbers
from tests.fitting.clouds import EXAMPLES

KINDS = tuple(EXAMPLES)


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_of_the_numbers_are_their_differences(kind: str) -> None:
    center, step = np.array([0.3, -0.2, 0.1]), 1e-6
    surface = EXAMPLES[kind].canonical(np.zeros(3))
    values, found = numbers(CODES[kind], surface.row(), center)
    np.testing.assert_allclose(values, values_of(surface.canonical(center)), rtol=1e-13, atol=1e-13)
    for i, unit in enumerate(step * np.eye(surface.dof)):
        ends = [values_of(stepped(surface, sign * unit).canonical(center)) for sign in (1.0, -1.0)]
        np.testing.assert_allclose(found[:, i], (ends[0] - ends[1]) / (2.0 * step), atol=1e-8)
