"""How well probabilities rank the truth: overall, by kind, by perturbation, by size of the cloud."""

import numpy as np
from numpy.typing import NDArray

from fitting.primitives import KINDS
from models.training.dataset import Dataset

SIZES = ((0, 300), (300, 1000), (1000, 3000), (3000, 8101))


def rank_of_truth(probabilities: NDArray[np.float64], labels: NDArray[np.int64]) -> NDArray[np.int64]:
    """0 where the truth has the highest probability; ties go to the kind that comes first."""
    order = np.argsort(-probabilities, axis=1, kind="stable")
    return np.argmax(order == labels[:, None], axis=1)


def metrics(probabilities: NDArray[np.float64], data: Dataset) -> dict[str, object]:
    """Shares in [0, 1] to four digits, ready for a card."""
    rank = rank_of_truth(probabilities, data.labels)
    perturbations = np.array(data.perturbations)

    def top1(chosen: NDArray[np.bool_]) -> float | None:
        return round(float(np.mean(rank[chosen] == 0)), 4) if chosen.any() else None

    return {
        "clouds": len(rank),
        "top1": round(float(np.mean(rank == 0)), 4),
        "top2": round(float(np.mean(rank <= 1)), 4),
        "top1_by_kind": {kind: top1(data.labels == index) for index, kind in enumerate(KINDS)},
        "top1_by_perturbation": {
            name: top1(perturbations == name) for name in sorted(set(data.perturbations))
        },
        "top1_by_size": {
            f"{low}-{high - 1}": top1((data.sizes >= low) & (data.sizes < high)) for low, high in SIZES
        },
    }
