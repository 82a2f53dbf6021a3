"""How far points are off every primitive: what a shape that is none of them deviates by."""

import numpy as np

from primfit.fitting.cloud.cloud import Cloud
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.search.kind import Fit, fit_kind
from primfit.fitting.trial.trial import Trial
from primfit.synthetic.recipes import KINDS

ENOUGH = 500
"""Points that a deviation is computed from: two digits."""


def off_every_kind(points: Array) -> float:
    """Root mean square distance of points (N, 3) without noise from the nearest primitive of any kind.

    By least squares over all of them, so no point is left out as an outlier.
    """
    cloud = Cloud.prepare(points[:: -(-len(points) // ENOUGH)], None, np.random.default_rng(0))
    fits = [fit_kind(Trial(kind, cloud), "least_squares", np.random.default_rng(0)) for kind in KINDS]
    found = [fit.finished.primitive for fit in fits if isinstance(fit, Fit)]
    squares = [np.mean(primitive.signed_distance(cloud.working) ** 2) for primitive in found]
    return cloud.frame.scale * float(np.sqrt(min(squares)))
