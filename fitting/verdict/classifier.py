"""What the pipeline needs of a classifier; it knows no more of them."""

from collections.abc import Mapping
from typing import Protocol

from ..geometry.vectors import Array


class Classifier(Protocol):
    """Ranks the kinds that a cloud may be."""

    def rank(self, points: Array, normals: Array) -> Mapping[str, float]:
        """A probability for each kind, from a sample of the cloud.

        Parameters
        ----------
        points : (N, 3) in the normalised frame (centroid near 0, extent near 1)
        normals : (N, 3) unit normals of those points, signs arbitrary
        """
        ...
