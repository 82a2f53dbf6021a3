"""Pieces as real parts have them: sizes are given, proportions, arcs and angles are drawn; lengths in metres.

Planes are table tops, floors and faces of boxes; cylinders pipes, cans and mugs; spheres balls and domes;
cones cups and funnels; tori elbows, rings and handles. What a view leaves of them the view decides.
"""

import numpy as np
from numpy.random import Generator

from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

from .canonical import ORIGIN, Z_AXIS
from .patches import Patch, Span
from .recipes import Range
from .scanner import Mode, log_uniform, pick

PLANE_SIDES = Range(0.1, 1.0)
"""Shorter over longer side, log-uniform: from a skirting board to a tile."""
SLENDERNESS = Range(1.0, 12.0)
"""Length of a cylinder over its radius: from a tuna can (35 mm high, 85 mm wide) to a pipe."""
HALF_ANGLE = Range(5.0, 60.0)
"""Of cones [deg], log-uniform: cups have 5 to 8, funnels and traffic cones 10 to 30, lamp shades more."""
RIM_RATIO = Range(1.4, 4.0)
"""Larger over smaller radius of a frustum, log-uniform; a 16 oz paper cup has 90 over 60 mm."""
ELBOW_RATIO = Range(1.5, 6.0)
"""Bend radius over pipe radius: elbows of 1 D and 1.5 D (ASME B16.9) have 2 and 3, bent tubes up to 6."""
RING_RATIO = Range(1.5, 6.0)
"""Of whole rings (tyres, swim rings, O-rings on a spool, doughnuts)."""
HANDLE_RATIO, HANDLE_ARC = Range(2.0, 5.0), Range(120.0, 200.0)
ELBOWS = (("45", 0.2), ("90", 0.6), ("180", 0.2))
TORI = (("elbow", 0.45), ("ring", 0.3), ("handle", 0.25))
SHORT_ARCS, SHORT_ARC = 0.15, Range(60.0, 120.0)
"""Shells of less than a half turn: gutters, panels, what is left of a can behind something else."""
CAP = Range(100.0, 200.0)
"""Of domes and bowls [deg], across."""
DOMES = 0.25
HOLLOW = 0.15
"""Of open pieces (arcs of up to a half turn) that are seen from within."""
OPEN = np.pi
"""Arcs up to which a hollow piece is open enough to be looked into."""


def around(degrees: float) -> Span:
    return -float(np.radians(degrees)) / 2, float(np.radians(degrees)) / 2


def azimuth(rng: Generator) -> Span:
    return around(log_uniform(rng, SHORT_ARC) if rng.random() < SHORT_ARCS else 360.0)


def plane(rng: Generator) -> Patch:
    side = log_uniform(rng, PLANE_SIDES)
    return Patch(Plane(Z_AXIS, ORIGIN), (-0.5, 0.5), (-side / 2, side / 2))


def sphere(rng: Generator) -> Patch:
    cap = log_uniform(rng, CAP) if rng.random() < DOMES else 360.0
    return Patch(Sphere(ORIGIN, 1.0), (-np.pi, np.pi), (0.0, float(np.radians(cap)) / 2))


def cylinder(rng: Generator) -> Patch:
    half = log_uniform(rng, SLENDERNESS) / 2
    return Patch(Cylinder(Z_AXIS, ORIGIN, 1.0), azimuth(rng), (-half, half))


def cone(rng: Generator) -> Patch:
    angle = float(np.radians(log_uniform(rng, HALF_ANGLE)))
    slant = np.cos(angle)
    return Patch(Cone(ORIGIN, Z_AXIS, angle), azimuth(rng), (slant / log_uniform(rng, RIM_RATIO), slant))


def torus(rng: Generator) -> Patch:
    match pick(rng, TORI):
        case "elbow":
            ratio, arc = log_uniform(rng, ELBOW_RATIO), float(pick(rng, ELBOWS))
        case "ring":
            ratio, arc = log_uniform(rng, RING_RATIO), 360.0
        case _:
            ratio, arc = log_uniform(rng, HANDLE_RATIO), log_uniform(rng, HANDLE_ARC)
    return Patch(Torus(ORIGIN, Z_AXIS, ratio, 1.0), around(arc), (-np.pi, np.pi))


PARTS = {"plane": plane, "sphere": sphere, "cylinder": cylinder, "cone": cone, "torus": torus}


def scaled(patch: Patch, scale: float) -> Patch:
    """The piece `scale` times as large; angles stay."""
    primitive = patch.primitive.transformed(np.eye(3), ORIGIN, scale)
    match primitive:
        case Plane():
            u, v = patch.u, patch.v
            return Patch(primitive, (scale * u[0], scale * u[1]), (scale * v[0], scale * v[1]))
        case Cylinder() | Cone():
            return Patch(primitive, patch.u, (scale * patch.v[0], scale * patch.v[1]))
    return Patch(primitive, patch.u, patch.v)


def draw_part(rng: Generator, kind: str, size: float) -> tuple[Patch, Mode]:
    """A piece of this kind whose bounding box has the diagonal `size` [m], and how it is seen."""
    patch = PARTS[kind](rng)
    corners = patch.sample(rng, 200)
    patch = scaled(patch, size / float(np.linalg.norm(np.ptp(corners, axis=0))))
    open_piece = {"sphere": patch.v[1] - patch.v[0] < OPEN / 2}.get(kind, patch.u[1] - patch.u[0] <= OPEN)
    if kind in ("plane", "torus") or not open_piece:
        return patch, "solid"
    return patch, "hollow" if rng.random() < HOLLOW else "shell"
