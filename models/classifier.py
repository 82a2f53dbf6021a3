"""What the classifiers on features share: loaded with their card, asked with points and normals."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.primitives.primitive import Primitive

from .features import features_and_fits
from .rough import KINDS
from .weights import load

Array = NDArray[np.float64]


class FeatureClassifier(ABC):
    """Ranks kinds by the features of a cloud; `NAME` is that of its weights, `sha256` their hash."""

    NAME: ClassVar[str]

    def __init__(self, arrays: Mapping[str, NDArray[Any]], sha256: str = "") -> None:
        self.sha256 = sha256

    @classmethod
    def shipped(cls) -> Self:
        """The shipped classifier; raises `WeightsMismatchError` when its weights do not fit the code."""
        arrays, card = load(cls.NAME)
        return cls(arrays, card.sha256)

    def rank(self, points: Array, normals: Array) -> dict[str, float]:
        """Probabilities of the kinds, summing to 1.

        Parameters
        ----------
        points : (N, 3), any frame and unit
        normals : (N, 3) unit normals, signs arbitrary
        """
        return self.rank_and_fit(points, normals)[0]

    def rank_and_fit(
        self, points: Array, normals: Array
    ) -> tuple[dict[str, float], Callable[[str], Primitive | None]]:
        """The same, and what gives the surface of a kind that was fitted roughly on the way."""
        row, fits = features_and_fits(points, normals)
        return dict(zip(KINDS, self.probabilities(row[None])[0].tolist(), strict=True)), fits.of

    @abstractmethod
    def probabilities(self, rows: Array) -> Array:
        """(M, N_FEATURES) -> (M, 5)"""
