"""M3, "PointNet": one PointNet tells the kind, one a kind says the parameters. There is no fit.

The paper
    Clouds are centered and scaled. A PointNet gives the probabilities of the five kinds and learns by
    cross-entropy. One more a kind, with a linear head for each parameter behind 256 features, says the
    parameters; its loss sums squared differences of radii and angles, distances of points, and
    1 - cos^8 + |v - v'|^2 of directions. The answer is carried back. 80% of the clouds are learned from.
It leaves open
    The scale; how many points are seen; widths, learning rate, augmentation; the sign of directions; where on
    a plane or an axis the point is.
Chosen
    The unit sphere; 256 points of a cloud for the kind and 512 for its parameters; the widths of
    `parts.pointnet`, about a third of those published; Adam (`training.stages`), no augmentation but other
    points each time. Signs and points are those of
    `parts.losses` and `parts.numbers`. The heads of a network are one layer, which is the same. Networks are
    measured on clouds of another seed instead of the last 20%.
"""

from pathlib import Path

from primfit.fitting.geometry.vectors import Array
from primfit.models.rough import KINDS

from .method import DIRECTORY, Found
from .parts.asking import probabilities, ranked, regressed, shown
from .parts.frames import answered
from .parts.normalization import unit_sphere
from .parts.stored import restored

POINTS = 256
"""For the kind: in the same time a network sees twice as many clouds as with 512."""
OF_PARAMETERS = 512


class RegressedByPointNet:
    """The kind and its parameters, by six networks."""

    name = "m3"
    title = "M3: PointNet"
    settings = (
        f"networks of paper/weights/m3-*, which see points in the unit sphere: {POINTS} for the kind, "
        f"{OF_PARAMETERS} for its parameters"
    )
    packages: tuple[str, ...] = ("torch",)

    def __init__(self, directory: Path = DIRECTORY) -> None:
        self.kinds = restored("m3-kind", directory)
        self.regressors = {kind: restored(f"m3-{kind}", directory) for kind in KINDS}

    def fit(self, points: Array) -> Found:
        """The most probable kind with the parameters that its network says."""
        return answered(unit_sphere, self.fit_inside, points)

    def fit_inside(self, points: Array) -> Found:
        """The same in the unit sphere."""
        chances = probabilities(self.kinds, shown(points, POINTS))
        kind = ranked(chances)[0]
        found = regressed(self.regressors[kind], kind, shown(points, OF_PARAMETERS))
        return Found(found, "", (kind,), chances)
