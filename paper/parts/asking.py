"""How a trained network is asked about one cloud."""

from dataclasses import dataclass

import numpy as np
import torch
from torch import nn

from primfit.fitting.cloud.frame import Frame
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives import values_of
from primfit.fitting.primitives.primitive import Primitive
from primfit.models.rough import KINDS

from .normalization import resampled, unit_sphere
from .numbers import from_numbers

Probabilities = tuple[tuple[str, float], ...]

SEED = 0
"""Which points are drawn of a cloud depends on nothing else."""
LARGEST = 1e150
"""Of coordinates."""
UNSEEN = f"there are no points, or coordinates over {LARGEST:g}"
"""Why there is no answer where `seen` gives none."""


@dataclass(frozen=True, eq=False)
class Seen:
    """A cloud in its unit sphere: the frame, and all points (N, 3)."""

    frame: Frame
    points: Array

    def shown(self, count: int) -> torch.Tensor:
        """So many of the points, as a network takes them: (1, count, 3)."""
        drawn = resampled(self.points, count, np.random.default_rng(SEED))
        return torch.from_numpy(drawn.astype(np.float32))[None]

    def restored(self, primitive: Primitive | None) -> Primitive | None:
        """In the unit of the input; None where its numbers are too large for that."""
        if primitive is None:
            return None
        with np.errstate(all="ignore"):
            found = self.frame.restore(primitive)
        return found if np.isfinite(values_of(found)).all() else None


def seen(points: Array) -> Seen | None:
    """Points (N, 3) in their unit sphere; None where there are none, or their squares are no numbers."""
    if not len(points) or np.abs(points).max() > LARGEST:
        return None
    with np.errstate(all="ignore"):
        frame = unit_sphere(points)
        return Seen(frame, frame.normalize(points))


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
