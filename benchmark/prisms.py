"""Bars whose section is no circle, and round pipes of the same sizes and noise beside them."""

import numpy as np
from numpy.random import Generator

from primfit.fitting.geometry.vectors import Z_AXIS, Array
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.primitive import Primitive
from primfit.synthetic import SyntheticCloud
from primfit.synthetic.recipes import Range
from primfit.synthetic.scanner import log_uniform, random_rotation
from primfit.synthetic.sections import bar, deviation, section

from .measures import diagonal
from .pieces import ORIGIN

POINTS = Range(200, 20_000)
LENGTH = Range(1.0, 5.0)
"""In widths of the section."""
NOISE, NOISELESS = Range(3e-4, 0.03), 1 / 8
"""Standard deviation along the normal over the width of the section, and how many clouds have none."""


def section_cloud(rng: Generator, sort: str) -> tuple[SyntheticCloud, float]:
    """A bar of this sort, and how far its section is off the nearest circle or line, in noise scales."""
    corners = section(rng, sort)
    noise, length, count = _draw(rng)
    cloud = _cloud(rng, *bar(rng, corners, length, count), noise, sort, None)
    return cloud, deviation(corners) / noise if noise else np.inf


def pipe_cloud(rng: Generator) -> SyntheticCloud:
    """A round pipe of width 1."""
    noise, length, count = _draw(rng)
    pipe = Cylinder(Z_AXIS, ORIGIN, 0.5)
    points = pipe.surface(rng.uniform(0.0, 2.0 * np.pi, count), length * rng.uniform(-0.5, 0.5, count))
    return _cloud(rng, points, pipe.gradient(points), noise, pipe.kind, pipe)


def _draw(rng: Generator) -> tuple[float, float, int]:
    """Noise, length and number of points."""
    noise = 0.0 if rng.random() < NOISELESS else log_uniform(rng, NOISE)
    return noise, log_uniform(rng, LENGTH), round(log_uniform(rng, POINTS))


def _cloud(
    rng: Generator, points: Array, normals: Array, noise: float, name: str, truth: Primitive | None
) -> SyntheticCloud:
    """Points (N, 3) of a surface with normal noise along its normals, turned and moved by up to 3 extents."""
    extent = diagonal(points)
    points = points + noise * rng.standard_normal((len(points), 1)) * normals
    rotation, shift = random_rotation(rng), extent * rng.uniform(-3.0, 3.0, 3)
    return SyntheticCloud(
        points @ rotation.T + shift,
        truth and truth.transformed(rotation, shift, 1.0),
        name,
        family="piece",
        noise=noise,
        extent=extent,
    )
