"""How well probabilities rank the truth, by family, kind, perturbation, sensor, size; and how honest."""

import numpy as np
from numpy.typing import NDArray

from ..rough import KINDS
from .dataset import Dataset

Array = NDArray[np.float64]

SIZES = ((0, 100), (100, 300), (300, 1000), (1000, 3000), (3000, 1_000_001))
CALIBRATION_BINS = 15


def rank_of_truth(probabilities: Array, labels: NDArray[np.int64]) -> NDArray[np.int64]:
    """0 where the truth has the highest probability; ties go to the kind that comes first."""
    order = np.argsort(-probabilities, axis=1, kind="stable")
    return np.argmax(order == labels[:, None], axis=1)


def calibration_error(probabilities: Array, labels: NDArray[np.int64]) -> float:
    """Expected calibration error of the first choice, in `CALIBRATION_BINS` equal bins of its probability.

    Guo et al., "On calibration of modern neural networks", ICML 2017, equation 3.
    """
    confidence = probabilities.max(axis=1)
    right = rank_of_truth(probabilities, labels) == 0
    bins = np.minimum((confidence * CALIBRATION_BINS).astype(int), CALIBRATION_BINS - 1)
    gaps = np.bincount(bins, right - confidence, CALIBRATION_BINS)
    return float(np.abs(gaps).sum() / len(labels))


def metrics(probabilities: Array, data: Dataset) -> dict[str, object]:
    """By family, the shares in [0, 1] to four digits, ready for a card."""
    return {
        family: _metrics(probabilities[data.families == family], data.where(data.families == family))
        for family in dict.fromkeys(data.families.tolist())
    }


def _metrics(probabilities: Array, data: Dataset) -> dict[str, object]:
    rank = rank_of_truth(probabilities, data.labels)

    def top1(chosen: NDArray[np.bool_]) -> float | None:
        return round(float(np.mean(rank[chosen] == 0)), 4) if chosen.any() else None

    return {
        "clouds": len(rank),
        "top1": round(float(np.mean(rank == 0)), 4),
        "top2": round(float(np.mean(rank <= 1)), 4),
        "calibration_error": round(calibration_error(probabilities, data.labels), 4),
        "top1_by_kind": {kind: top1(data.labels == index) for index, kind in enumerate(KINDS)},
        "top1_by_perturbation": {
            str(name): top1(data.perturbations == name) for name in np.unique(data.perturbations) if name
        },
        "top1_by_sensor": {str(name): top1(data.sensors == name) for name in np.unique(data.sensors) if name},
        "top1_by_size": {
            f"{low}-{high - 1}": top1((data.sizes >= low) & (data.sizes < high)) for low, high in SIZES
        },
    }
