"""The nearest references of a histogram, each with a label."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class References:
    """Histograms (M, D) and their labels (M,), which are small whole numbers."""

    rows: Rows
    labels: NDArray[np.int64]

    @cached_property
    def squares(self) -> Rows:
        return np.einsum("ij,ij->i", self.rows, self.rows)

    def votes(self, asked: Rows, k: int, labels: int) -> NDArray[np.float64]:
        """Shares (labels,) of the labels among the `k` nearest of each of the asked histograms (Q, D)."""
        k = min(k, len(self.rows))
        if not len(asked) or not k:
            return np.full(labels, 1.0 / labels)
        distances = self.squares - 2.0 * asked @ self.rows.T
        nearest = np.argpartition(distances, k - 1, axis=1)[:, :k]
        return np.bincount(self.labels[nearest].ravel(), minlength=labels) / nearest.size

    def of(self, chosen: NDArray[np.bool_]) -> "References":
        """Those of some labels, given for each label (L,) whether it is one of them."""
        kept = chosen[self.labels]
        return References(self.rows[kept], self.labels[kept])
