"""M1, "Accelerated Hough transform": every kind is voted for, and the one with the least mean error wins.

The paper
    Normals come from a Hough transform with planes in the Hesse normal form (Limberger and Oliveira). For
    each kind the geometry of the kind tells which rotation and translation bring the cloud to its canonical
    position, and about which sizes it has: radii, or the half-angle of a cone. There the Hough transform
    votes in a parameter space of fewer dimensions, near these sizes. The surface is sampled, and the mean
    fitting error of the kinds is compared: the kind with the lowest is answered.
It leaves open
    The cells of the votes; how canonical positions are found; how densely surfaces are sampled; what is
    looked at of a large cloud. (The article that it cites, "Fitting and recognition of geometric primitives
    in segmented 3D point clouds using a localized voting procedure", CAGD 97, 2022, finds axes and centers by
    the normals, too.)
Chosen
    Normals as in `parts.hough_normals`, at 300 points. Axes are voted for on half a sphere by the angle that
    most normals have with them; those of `fitting.guesses` compete, from principal normals and line geometry.
    About each axis a closed-form fit gives center or apex, and a histogram the size, zoomed in three times;
    of a torus the major radius is voted on together with the minor one. The candidate that most of 1,000
    points vote for counts. Radii are at most 8 root mean square extents, half-angles 10 to 80 degrees, and a
    torus's radii have a ratio up to 10. Surfaces are sampled 100 times along each parameter, and the error is
    that of 500 points. It tells no kind from another one within a sample's distance: there the coarser
    sampling of the richer kinds decides.
"""

import numpy as np

from primfit.fitting.cloud.frame import Frame
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.primitive import Primitive

from .method import Found
from .parts.frames import answered
from .parts.hough_normals import hough_normals
from .parts.sampled import sampled_error
from .parts.standing import STANDING, Seen

VOTERS = 1000
NORMALS = 300
MEASURED = 500
"""Points that vote; the first of them have normals; the error is the mean over so many."""
SEED = 0


class HoughTransform:
    """Every kind by votes; no weights."""

    name = "m1"
    title = "M1: accelerated Hough transform"
    settings = "1,000 points vote, 300 of them with normals; radii up to 8 root mean square extents"
    packages: tuple[str, ...] = ()

    def fit(self, points: Array) -> Found:
        """The kind with the lowest mean fitting error, as it was voted for."""
        return answered(Frame.of, fit_inside, points)


def fit_inside(points: Array) -> Found:
    """The same in a frame at the centroid, with root mean square distances near 1."""
    seen = seen_of(points)
    voted = {kind: seen.most_voted(candidates(seen)) for kind, candidates in STANDING.items()}
    found = {kind: surface for kind, surface in voted.items() if surface is not None}
    errors = {kind: error_of(surface, seen) for kind, surface in found.items()}
    finite = [kind for kind, error in errors.items() if np.isfinite(error)]
    if not finite:
        return Found(None, "no kind gets a vote", tuple(found))
    return Found(found[min(finite, key=errors.__getitem__)], "", tuple(found))


def seen_of(points: Array) -> Seen:
    """Some of the points, in random order, and normals of the first."""
    rng = np.random.default_rng(SEED)
    voters = points[rng.permutation(len(points))[:VOTERS]]
    return Seen(voters, *hough_normals(points, voters[:NORMALS], rng))


def error_of(surface: Primitive, seen: Seen) -> float:
    """The mean fitting error on some of the points."""
    return sampled_error(surface, seen.points[:MEASURED])
