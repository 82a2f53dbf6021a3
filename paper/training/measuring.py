"""How good a network is, on clouds that it has not learned from."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from primfit.models.rough import KINDS

from ..parts.numbers import DIRECTION, LAYOUT, POSITION
from .batches import Batch, plain_batch
from .clouds import Clouds
from .stages import Stage

ASKED = 100
"""Clouds that a network is asked about at a time."""

Rows = NDArray[np.float64]


def measured(stage: Stage, network: nn.Module, clouds: Clouds) -> dict[str, Any]:
    """The metrics of a card: of a classifier what it gets right, of a regressor the track's L2 distance."""
    network.eval()
    with torch.no_grad():
        found = np.concatenate([network(batch.inputs).double().numpy() for batch in _plain(stage, clouds)])
    metrics = _of_kinds(found, clouds) if stage.kind is None else _of_numbers(stage.kind, found, clouds)
    return {"clouds": len(clouds.labels), **metrics}


def _plain(stage: Stage, clouds: Clouds) -> Iterator[Batch]:
    return (
        plain_batch(stage, clouds, slice(first, first + ASKED))
        for first in range(0, len(clouds.labels), ASKED)
    )


def _of_kinds(logits: Rows, clouds: Clouds) -> dict[str, Any]:
    right = logits.argmax(axis=1) == clouds.labels
    of_kind = {kind: round(float(right[clouds.labels == k].mean()), 4) for k, kind in enumerate(KINDS)}
    return {"top1": round(float(right.mean()), 4), "top1_of_kind": of_kind}


def _of_numbers(kind: str, found: Rows, clouds: Clouds) -> dict[str, Any]:
    distances = l2(kind, found, clouds.numbers.astype(float), clouds.scales)
    quartiles = np.quantile(distances, (0.25, 0.5, 0.75))
    return {"l2_quartiles": [float(f"{value:.4g}") for value in quartiles]}


def l2(kind: str, found: Rows, truth: Rows, scales: NDArray[np.float64]) -> NDArray[np.float64]:
    """The track's distances (M,) in the units of the clouds, minimal over the sign of the direction.

    The points of planes and cylinders are left out, as the track does.
    """
    direction, position, sizes = LAYOUT[kind]
    squared = np.zeros(len(found))
    if position in ("center", "apex"):
        squared += (np.square(found - truth)[:, POSITION]).sum(axis=1) * scales**2
    for place, name in enumerate(sizes, 6):
        squared += np.square(found - truth)[:, place] * (1.0 if name == "half_angle" else scales**2)
    if direction is not None:
        lengths = np.linalg.norm(found[:, DIRECTION], axis=1, keepdims=True)
        units = found[:, DIRECTION] / np.maximum(lengths, 1e-300)
        apart = [np.square(units - sign * truth[:, DIRECTION]).sum(axis=1) for sign in (1.0, -1.0)]
        squared += np.minimum(*apart)
    return np.sqrt(squared)
