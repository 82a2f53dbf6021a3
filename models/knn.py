"""Nearest neighbors among labeled clouds, in the plane of features that separates the kinds best."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .classifier import FeatureClassifier
from .features import N_FEATURES
from .rough import KINDS

Array = NDArray[np.float64]

NEIGHBOURS = 25
SMOOTHING = 0.05
"""Votes that every kind starts with, so that none is ever impossible."""
CLIP = 4.0
"""Standardized features are held within this many standard deviations."""


@dataclass(frozen=True, eq=False)
class Embedding:
    """Features -> a few coordinates in which distance means difference of kind.

    Attributes
    ----------
    mean, scale : (N_FEATURES,) of the features
    projection : (N_FEATURES, D), applied to the clipped, standardized features
    """

    mean: Array
    scale: Array
    projection: Array

    def __call__(self, rows: Array) -> Array:
        """(..., N_FEATURES) -> (..., D)"""
        return np.clip((rows - self.mean) / self.scale, -CLIP, CLIP) @ self.projection


class KnnClassifier(FeatureClassifier):
    """k nearest neighbors; `sha256` names the weights.

    Parameters
    ----------
    arrays : `mean`, `scale`, `projection` of the `Embedding`, and `references` (M, D) with their `labels`
        (M,), indices into the five kinds
    sha256 : of the weights
    """

    NAME = "knn"

    def __init__(self, arrays: Mapping[str, NDArray[Any]], sha256: str = "") -> None:
        super().__init__(arrays, sha256)
        self.embedding = Embedding(
            *(arrays[name].astype(np.float64) for name in ("mean", "scale", "projection"))
        )
        self.labels = arrays["labels"].astype(np.int64)
        self.coordinates = np.ascontiguousarray(arrays["references"].T, np.float64)
        self.neighbors = min(NEIGHBOURS, len(self.labels))
        if self.embedding.projection.shape[0] != N_FEATURES:
            raise ValueError(f"a projection of {N_FEATURES} features is needed")

    def probabilities(self, rows: Array) -> Array:
        """(M, N_FEATURES) -> (M, 5): smoothed shares of the votes."""
        nearest = np.array([self._nearest(point) for point in self.embedding(rows)])
        votes = (self.labels[nearest][:, :, None] == np.arange(len(KINDS))).sum(axis=1) + SMOOTHING
        return votes / votes.sum(axis=1, keepdims=True)

    def _nearest(self, point: Array) -> NDArray[np.intp]:
        """The references nearest to a point (D,), in any order.

        All are looked at: a quarter of a millisecond, where a library of trees takes half a second to import.
        """
        squares = np.zeros(len(self.labels))
        for coordinate, value in zip(self.coordinates, point, strict=True):
            squares += (coordinate - value) ** 2
        return np.argpartition(squares, self.neighbors - 1)[: self.neighbors]
