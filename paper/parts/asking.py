"""How a trained network is asked about one cloud."""

import numpy as np
import torch
from torch import nn

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.primitive import Primitive
from primfit.models.rough import KINDS

from .normalization import resampled
from .numbers import from_numbers

Probabilities = tuple[tuple[str, float], ...]

SEED = 0
"""Which points are drawn of a cloud depends on nothing else."""


def shown(points: Array, count: int) -> torch.Tensor:
    """So many of the points (N, 3), as a network takes them: (1, count, 3)."""
    drawn = resampled(points, count, np.random.default_rng(SEED))
    return torch.from_numpy(drawn.astype(np.float32))[None]


def numbers(network: nn.Module, inputs: torch.Tensor) -> Array:
    """What a network says of one cloud."""
    with torch.no_grad():
        said: torch.Tensor = network(inputs)[0]
    return np.asarray(said.double().numpy())


def probabilities(network: nn.Module, inputs: torch.Tensor) -> Probabilities:
    """Of the kinds, by a classifier."""
    logits = numbers(network, inputs)
    shares = np.exp(logits - logits.max())
    return tuple(zip(KINDS, (shares / shares.sum()).tolist(), strict=True))


def ranked(chances: Probabilities) -> list[str]:
    """The kinds, the most probable first."""
    return [kind for kind, _ in sorted(chances, key=lambda pair: -pair[1])]


def regressed(network: nn.Module, kind: str, inputs: torch.Tensor) -> Primitive:
    """In the unit sphere, by a regression network."""
    return from_numbers(kind, numbers(network, inputs))
