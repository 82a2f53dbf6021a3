"""Short arcs of cones whose angle the points show, and of cylinders beside them.

How much the points show is the chi^2 of the angle: twice what the best cone gains in log-likelihood on the
best cylinder under independent noise of the known size. To first order that is the square of the estimated
angle over its variance, once the other parameters have taken what they can.
"""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from primfit.fitting.cloud.frame import Frame
from primfit.fitting.geometry.vectors import Z_AXIS, Array
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.solver.refine import refine
from primfit.synthetic import SyntheticCloud
from primfit.synthetic.recipes import Range
from primfit.synthetic.scanner import log_uniform

from .measures import diagonal
from .pieces import ORIGIN, noisy

HALF_ANGLE, ARC = Range(20.0, 60.0), Range(30.0, 60.0)
"""Degrees, uniform."""
RADIUS_CHANGE = Range(1.8, 2.2)
"""The larger radius over the smaller: it doubles, give or take a tenth."""
POINTS = Range(300, 20_000)
CHI_SQUARED = Range(20.0, 500.0)
"""What the noise is drawn for, log-uniform: the angle is 4.5 to 22 standard errors from 0."""
MOST_NOISE = 0.03
"""Standard deviation over the extent: three times what an arc of so few degrees is off its plane. Cones whose
points are too many to need less are drawn again."""
STEPS = 500
"""Of least squares at most: the angle of a short arc lies in a narrow valley."""


@dataclass(frozen=True, eq=False)
class Arc:
    """A canonical cone with points (N, 3) on it, so many radians around, of so long a slant."""

    cone: Cone
    points: Array
    around: float
    slant: float

    @property
    def radius(self) -> float:
        """The mean of the points."""
        return float(np.mean(np.hypot(self.points[:, 0], self.points[:, 1])))


def arc_cloud(rng: Generator, shape: str) -> tuple[SyntheticCloud, float]:
    """A cloud of a cone, or of the cylinder beside it, and the chi^2 of the angle of that cone's cloud.

    Clouds of cones that show less of the angle than the law allows are drawn again.
    """
    while True:
        arc = draw_arc(rng)
        noise = noise_of(arc, log_uniform(rng, CHI_SQUARED))
        if noise > MOST_NOISE * diagonal(arc.points):
            continue
        cloud = noisy(rng, arc.cone, arc.points, noise, "along the normal")
        shown = chi_squared(cloud)
        if shown > CHI_SQUARED.low:
            break
    if shape == "cylinder":
        cloud = noisy(rng, *beside(rng, arc), noise, "along the normal")
    return cloud, shown


def draw_arc(rng: Generator) -> Arc:
    """Points uniform in area on a frustum whose slant reaches 1 at the larger end."""
    count, around = round(log_uniform(rng, POINTS)), np.radians(rng.uniform(ARC.low, ARC.high))
    half_angle = np.radians(rng.uniform(HALF_ANGLE.low, HALF_ANGLE.high))
    start = 1.0 / log_uniform(rng, RADIUS_CHANGE)
    cone = Cone(ORIGIN, Z_AXIS, float(half_angle))
    slant = np.sqrt(rng.uniform(start**2, 1.0, count))
    points = cone.surface(around * rng.uniform(-0.5, 0.5, count), slant * np.cos(half_angle))
    return Arc(cone, points, float(around), 1.0 - start)


def beside(rng: Generator, arc: Arc) -> tuple[Cylinder, Array]:
    """The cylinder of the cone's mean radius, as far around and as long, with as many points (N, 3)."""
    cylinder, count = Cylinder(Z_AXIS, ORIGIN, arc.radius), len(arc.points)
    around, along = arc.around * rng.uniform(-0.5, 0.5, count), arc.slant * rng.uniform(-0.5, 0.5, count)
    return cylinder, cylinder.surface(around, along)


def noise_of(arc: Arc, chi: float) -> float:
    """The noise under which the angle has this chi^2 on the average, less the 1 that noise adds to it."""
    squares = np.sum(nearest_cylinder(arc.cone, arc.points).signed_distance(arc.points) ** 2)
    return float(np.sqrt(squares / chi))


def chi_squared(cloud: SyntheticCloud) -> float:
    """Of the angle, on noisy points: what is left by the best cylinder less what is left by the best cone."""
    assert isinstance(cloud.primitive, Cone) and cloud.noise
    cylinder = nearest_cylinder(cloud.primitive, cloud.points)
    cone = least_squares(cloud.primitive, cloud.points)
    left = [float(np.sum(surface.signed_distance(cloud.points) ** 2)) for surface in (cylinder, cone)]
    return (left[0] - left[1]) / cloud.noise**2


def nearest_cylinder(cone: Cone, points: Array) -> Primitive:
    """The least-squares one, from that which osculates the cone at the foot of the points' middle."""
    middle = points.mean(axis=0)
    normal = cone.gradient(middle[None])[0]
    foot = middle - cone.signed_distance(middle[None])[0] * normal
    along = (foot - cone.apex) / np.linalg.norm(foot - cone.apex)
    radius = float((foot - cone.apex) @ along * np.tan(cone.half_angle))
    return least_squares(Cylinder(along, foot - radius * normal, radius), points)


def least_squares(start: Primitive, points: Array) -> Primitive:
    frame = Frame.of(points)
    found = refine(frame.bring(start), frame.normalize(points), max_iterations=STEPS)
    return frame.restore(found.primitive)
