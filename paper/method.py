"""What a method of the paper is, and where each of them is found."""

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Protocol

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.primitive import Primitive

DIRECTORY = Path(__file__).with_name("weights")
"""Where weights are, in a checkout."""


@dataclass(frozen=True)
class Found:
    """What a method says of a cloud.

    Attributes
    ----------
    primitive : in the units of the input; None where the method found nothing
    note : why there is none, or what else is worth keeping; may be empty
    attempts : the kinds that were fitted, in order
    probabilities : of the kinds, where the method has any; empty where it has none
    """

    primitive: Primitive | None
    note: str = ""
    attempts: tuple[str, ...] = ()
    probabilities: tuple[tuple[str, float], ...] = ()


class Method(Protocol):
    """From points to a primitive. Constructed without arguments, which loads its weights.

    Attributes
    ----------
    name : as in `METHODS`
    title : as the paper calls it
    settings : one sentence for the report: the settings used and how they scale with the cloud
    packages : those whose version decides its numbers, beside numpy and scipy
    """

    name: str
    title: str
    settings: str
    packages: tuple[str, ...]

    def fit(self, points: Array) -> Found:
        """The answer for one cloud; the same for the same points.

        Parameters
        ----------
        points : (N, 3) float64, finite, any unit; not to be written to

        Notes
        -----
        Never raises for finite points, however few or degenerate: what cannot be answered is a `Found`
        without a primitive whose note says why.
        """
        ...


METHODS: dict[str, str] = {
    "m1": "primfit.paper.m1:HoughTransform",
    "m2": "primfit.paper.m2:LocalHistograms",
    "m3": "primfit.paper.m3:RegressedByPointNet",
    "m4": "primfit.paper.m4:ShapeNets",
    "m5": "primfit.paper.m5:PointNetBundle",
    "m6": "primfit.paper.m6:AlexNetIso",
}
"""Name -> "module:Class", imported by `load` alone, so that one method does not need what another does."""


def load(name: str) -> Method:
    """The method of that name, constructed.

    Raises
    ------
    ImportError : what it is made of is not installed (torch: the extra `train`)
    primfit.models.weights.WeightsMismatchError : its weights are not there, or not those of this code
    """
    module, _, attribute = METHODS[name].partition(":")
    method: Method = getattr(import_module(module), attribute)()
    return method
