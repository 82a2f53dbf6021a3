"""M2, "Histograms of local features and parameter fitting": neighbors find the kind, fits the numbers.

The paper
    A cloud is brought to a unit cube. A 25 x 25 histogram of oriented normal vectors is shifted so that each
    cell with at least 80% of the maximum is in the middle once: a cloud has several histograms. By these
    k-NN (k = 3) tells planes from the rest, and principal components check them. The rest is told by k-NN
    (k = 5), with spheres and tori as one category, and cones and cylinders as two (strategy 1) or as one
    that another k-NN (k = 5) splits (strategy 2). Spheres are told from tori by histograms of surflet-pair
    relations (k = 15). Then: the principal plane; the best of 100 spheres by least squares on 30% of the
    points each, where a point farther off than 5% of the radius is an outlier; the cylinder of least
    squares; a cone by RANSAC; a circle by least squares, and the torus about it of the mean distance.
It leaves open
    How normals are estimated and signed; the distance between histograms; how the answers of several
    histograms of a cloud are joined; the threshold of the check; which strategy counts; the numbers of the
    RANSAC; how many of the 46,000 clouds are references.
Chosen
    Normals by principal components of 16 neighbors, at 800 points, each counted with its opposite. Histograms
    of normals are compared by the distance of Hellinger, those of surflets, 625 cells of 150 points, by that
    of Euclid. All histograms of a cloud vote. A plane is believed if it is as flat as 99% of the reference
    planes. The shares of both strategies are added. 6,000 synthetic clouds are references
    (`training.m2`). The RANSAC is that of `parts.ransac_cone`.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.geometry.vectors import Array, principal
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.models.rough import KINDS
from primfit.models.weights import load

from .method import DIRECTORY, Found
from .parts.circle import torus_about_circle
from .parts.frames import answered, unit_cube
from .parts.least_squares import least_squares
from .parts.local_histograms import Local, peaked, shares_of
from .parts.nearest import References
from .parts.ransac_cone import ransac_cone
from .parts.sampled_sphere import sampled_sphere

PLANE_NEIGHBOURS, NEIGHBOURS, SURFLET_NEIGHBOURS = 3, 5, 15
PLANE, SPHERE, CYLINDER, CONE, TORUS = (
    KINDS.index(kind) for kind in ("plane", "sphere", "cylinder", "cone", "torus")
)
SEED = 0


class LocalHistograms:
    """The kind by nearest neighbors among histograms, the parameters by direct fits."""

    name = "m2"
    title = "M2: histograms of local features and parameter fitting"
    settings = "k = 3, 5 and 15 as in the paper, in the unit cube; a cone's points lie within 1% of its side"
    packages: tuple[str, ...] = ()

    def __init__(self) -> None:
        arrays, _ = load("m2", DIRECTORY)
        self.flattest = float(arrays["flatness"][0])
        normals = [peaked(row) for row in arrays["normals"]]
        owners = np.repeat(arrays["labels"], [len(rows) for rows in normals]).astype(np.int64)
        self.all = References(np.vstack(normals), owners)
        self.curved = self.all.of(chosen(SPHERE, CYLINDER, CONE, TORUS))
        self.straight = self.all.of(chosen(CYLINDER, CONE))
        pairs = arrays["labels"][chosen(SPHERE, TORUS)[arrays["labels"]]].astype(np.int64)
        self.pairs = References(shares_of(arrays["surflets"]), pairs)

    def fit(self, points: Array) -> Found:
        """The kind that neighbors name, fitted."""
        return answered(unit_cube, self.fit_inside, points)

    def fit_inside(self, points: Array) -> Found:
        """The same in the unit cube."""
        local = Local.of(points)
        kind = self.kind_of(local)
        primitive = FITS[kind](points, local)
        return Found(primitive, "" if primitive else f"no {kind} is determined by the points", (kind,))

    def kind_of(self, local: Local) -> str:
        """Step by step, as the paper does it."""
        asked = peaked(local.normals)
        flat = self.all.votes(asked, PLANE_NEIGHBOURS, len(KINDS))[PLANE] > 0.5
        if flat and local.flatness <= self.flattest:
            return "plane"
        first = self.curved.votes(asked, NEIGHBOURS, len(KINDS))
        split = self.straight.votes(asked, NEIGHBOURS, len(KINDS))
        second = (first[CYLINDER] + first[CONE]) * split
        straight = first + second
        if straight[CYLINDER] + straight[CONE] <= 2.0 * (first[SPHERE] + first[TORUS]):
            pairs = shares_of(local.surflets)[None]
            return KINDS[int(np.argmax(self.pairs.votes(pairs, SURFLET_NEIGHBOURS, len(KINDS))))]
        return "cylinder" if straight[CYLINDER] >= straight[CONE] else "cone"


def chosen(*kinds: int) -> NDArray[np.bool_]:
    """For each kind whether it is one of these."""
    return np.isin(np.arange(len(KINDS)), kinds)


def principal_plane(points: Array, local: Local) -> Plane:
    """Through the mean of the points, across the direction that they scatter least in."""
    center = points.mean(axis=0)
    return Plane(principal(points - center)[1][:, 2], center)


def sphere_by_samples(points: Array, local: Local) -> Primitive | None:
    return sampled_sphere(points, np.random.default_rng(SEED))


def cone_by_ransac(points: Array, local: Local) -> Primitive | None:
    return ransac_cone(local.oriented, points, np.random.default_rng(SEED))


FITS: dict[str, Callable[[Array, Local], Primitive | None]] = {
    "plane": principal_plane,
    "sphere": sphere_by_samples,
    "cylinder": lambda points, local: least_squares("cylinder", points),
    "cone": cone_by_ransac,
    "torus": lambda points, local: torus_about_circle(points),
}
