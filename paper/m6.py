"""M6, "AlexNet and ISO": images along the principal directions tell the kind, least squares fits it.

The paper
    Clouds are centered, scaled into the unit sphere and turned so that the first principal axis is z. Images
    from the principal directions go into AlexNet, of which all but the last three layers are pretrained; a
    fully connected layer of five numbers and a softmax are new. The kind is an invariance class of ISO's
    geometrical product specifications, and least squares gives its ideal feature. 95% of the clouds are
    learned from, in six epochs.
It leaves open
    What the images show, their size and number; augmentation; the start of least squares.
Chosen
    All of `parts.views`: one picture of six channels, 48 pixels wide, and a smaller AlexNet without
    pretrained weights, which are not to be had with this project; 2,048 points of a cloud; while it learns,
    clouds are mirrored along principal axes. It is measured on clouds of another seed. Least squares starts
    from closed forms (`parts.least_squares`).
"""

from pathlib import Path

from primfit.fitting.geometry.vectors import Array

from .method import DIRECTORY, Found
from .parts.asking import probabilities, ranked, shown
from .parts.frames import answered
from .parts.least_squares import least_squares
from .parts.normalization import unit_sphere
from .parts.stored import restored
from .parts.views import principal_views

POINTS = 2048


class AlexNetIso:
    """The kind by images, the parameters by least squares."""

    name = "m6"
    title = "M6: AlexNet and ISO reconstruction standards"
    settings = f"the network of paper/weights/m6-kind, whose images show {POINTS:,} points in the unit sphere"
    packages: tuple[str, ...] = ("torch",)

    def __init__(self, directory: Path = DIRECTORY) -> None:
        self.network = restored("m6-kind", directory)

    def fit(self, points: Array) -> Found:
        """The most probable kind, fitted."""
        return answered(unit_sphere, self.fit_inside, points)

    def fit_inside(self, points: Array) -> Found:
        """The same in the unit sphere."""
        chances = probabilities(self.network, principal_views(shown(points, POINTS)))
        kind = ranked(chances)[0]
        primitive = least_squares(kind, points)
        note = "" if primitive else f"least squares finds no {kind}"
        return Found(primitive, note, (kind,), chances)
