"""What the pipeline needs of a classifier; it knows no more of them."""

from collections.abc import Callable, Mapping
from typing import Protocol, runtime_checkable

from ..geometry.vectors import Array
from ..primitives.primitive import Primitive


class Classifier(Protocol):
    """Ranks the kinds that a cloud may be."""

    def rank(self, points: Array, normals: Array) -> Mapping[str, float]:
        """A probability for each kind, from a sample of the cloud.

        Parameters
        ----------
        points : (N, 3) in the normalized frame (centroid near 0, extent near 1)
        normals : (N, 3) unit normals of those points, signs arbitrary
        """
        ...


@runtime_checkable
class FittingClassifier(Classifier, Protocol):
    """One that fits kinds roughly on its way, which spares the search its starts where points are exact."""

    def rank_and_fit(
        self, points: Array, normals: Array
    ) -> tuple[Mapping[str, float], Callable[[str], Primitive | None]]:
        """As `rank`, and what gives the rough surface of a kind in the frame of the points, or None."""
        ...
