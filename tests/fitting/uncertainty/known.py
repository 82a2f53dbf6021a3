"""What several tests of the uncertainty ask: what is known of a cloud, short arcs, costs of a plane."""

import numpy as np

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.uncertainty.covariance import Linear
from primfit.fitting.uncertainty.values import Uncertainty


def known(points: Array, kind: str, **options: object) -> Uncertainty:
    found = recognize(points, Config(kinds=(kind,), **options)).uncertainty
    assert found is not None
    return found


def codes(found: Uncertainty) -> set[str]:
    return {warning.code for warning in found.warnings}


def arc(degrees: float, n: int, sigma: float, seed: int) -> Array:
    rng = np.random.default_rng(seed)
    half = np.radians(degrees) / 2
    cylinder = Cylinder([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 1.0)
    points = cylinder.surface(rng.uniform(-half, half, n), rng.uniform(-1.0, 1.0, n))
    return points + sigma * rng.standard_normal((n, 1)) * cylinder.gradient(points)


def flat(n: int, rng: np.random.Generator) -> Linear:
    """A cost of a plane over the unit square, linearized about it, with pulls of unit noise."""
    feet = rng.uniform(0.0, 1.0, (n, 3)) * [1.0, 1.0, 0.0]
    rows = np.ascontiguousarray(np.vstack([np.ones(n), feet[:, :2].T]))
    left = rng.standard_normal(n)
    return Linear(rows, None, left, left, np.ones(n), np.ones(n), np.ascontiguousarray(feet.T), 1.0)
