"""Parts that deviate smoothly from their kind, by a known multiple of their noise.

The deviation is what is left of a bow, lobes or a barrel when the parameters of the kind have taken what they
can, to first order: so the truth is the surface of its kind that is nearest to the part, and no estimate can
take the deviation away.
"""

import numpy as np
from numpy.random import Generator

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.solver.refine import linearize
from primfit.synthetic import SyntheticCloud
from primfit.synthetic.bows import DEVIATIONS, draw_piece
from primfit.synthetic.recipes import Range
from primfit.synthetic.scanner import log_uniform, random_rotation

from .measures import diagonal

POINTS = Range(200, 50_000)
NOISE = Range(2e-4, 5e-3)
"""Standard deviation along the normal over the extent: from structured light to a depth camera."""
LEAST_LEFT = 0.02
"""Deviations of which the parameters take all but this share (rms) are drawn again: what is left of them is
no bow, lobe or barrel."""


def bowed_cloud(rng: Generator, kind: str, deviation: str, amplitude: float) -> SyntheticCloud:
    """A part with white noise whose deviation has a root mean square of `amplitude` standard deviations.

    Points, noise, sign and direction are drawn first, so that only the size of the deviation follows it.
    """
    count, share = round(log_uniform(rng, POINTS)), log_uniform(rng, NOISE)
    truth, points, field = deviating(rng, kind, deviation, count)
    extent = diagonal(points)
    noise = share * extent
    heights = noise * (amplitude * field + rng.standard_normal(count))
    points = points + heights[:, None] * truth.gradient(points)
    rotation, shift = random_rotation(rng), extent * rng.uniform(-3.0, 3.0, 3)
    return SyntheticCloud(
        points @ rotation.T + shift,
        truth.transformed(rotation, shift, 1.0),
        kind,
        family="piece",
        noise=noise,
        extent=extent,
    )


def deviating(rng: Generator, kind: str, deviation: str, count: int) -> tuple[Primitive, Array, Array]:
    """A surface, points (N, 3) on it, and a deviation (N,) of unit root mean square and either sign."""
    while True:
        piece = draw_piece(rng, kind, count)
        field = DEVIATIONS[deviation](rng, piece)
        left = beyond(piece.primitive, piece.points, field)
        size = float(np.sqrt(np.mean(left**2)))
        if size > LEAST_LEFT * float(np.std(field)):
            return piece.primitive, piece.points, rng.choice([-1.0, 1.0]) / size * left


def beyond(truth: Primitive, points: Array, field: Array) -> Array:
    """The part of a field (N,) that no small change of the surface's parameters makes."""
    basis = np.linalg.qr(linearize(truth, points)[1])[0]
    return field - basis @ (basis.T @ field)
