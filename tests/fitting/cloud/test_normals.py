"""Normals that are estimated follow the surface."""

import numpy as np
import pytest

from primfit.fitting.cloud.normals import estimate_normals
from primfit.fitting.primitives.primitive import Primitive
from tests.fitting.clouds import EXAMPLES, sample

examples = pytest.mark.parametrize("primitive", EXAMPLES.values(), ids=EXAMPLES.keys())


@examples
def test_normals_follow_the_surface(primitive: Primitive) -> None:
    points = sample(primitive, 4000)
    agreement = np.abs(np.einsum("ij,ij->i", estimate_normals(points), primitive.gradient(points)))
    assert np.median(agreement) > 0.999
