"""One network's training, that goes on where it was cut off."""

import math
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from ..parts.losses import m3_loss, m4_loss
from ..parts.pointnet import PointNet
from ..parts.stored import built
from .batches import Batch, drawn_batch
from .clouds import Clouds
from .stages import Stage

EPOCH = 3_000
"""Clouds of an epoch, drawn from all without repetition; a checkpoint is kept after each."""
WARM = 0.1
"""Share of the steps in which the learning rate rises; it falls along half a cosine after that."""
ALIKE = 1e-3
"""Weight of the loss that keeps the alignment of PointNet's features near a rotation: the published one."""
STEEPEST = 1.0
"""Longer gradients are shortened to this, for clouds of which the truth is far away."""


@dataclass(frozen=True, eq=False)
class Learner:
    """A network in training, its optimizer, and the learning curve so far."""

    network: nn.Module
    optimizer: torch.optim.Adam
    curve: list[float]

    def kept(self) -> dict[str, Any]:
        """What a checkpoint holds."""
        return {
            "network": self.network.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "curve": self.curve,
        }


def begun(stage: Stage, seed: int, checkpoint: Path) -> Learner:
    """As the checkpoint left it, or from the start."""
    torch.manual_seed(seed + stage.seed)
    network = built(stage.network)
    learner = Learner(network, torch.optim.Adam(network.parameters(), stage.rate), [])
    if checkpoint.exists():
        found = torch.load(checkpoint, weights_only=True)
        learner.network.load_state_dict(found["network"])
        learner.optimizer.load_state_dict(found["optimizer"])
        learner.curve.extend(found["curve"])
    return learner


def keep(learner: Learner, checkpoint: Path) -> None:
    """Write a checkpoint, whole or not at all."""
    part = checkpoint.with_suffix(f".{os.getpid()}.part")
    torch.save(learner.kept(), part)
    part.replace(checkpoint)


def learned(
    stage: Stage,
    data: Clouds,
    seed: int,
    checkpoint: Path,
    told: Callable[[str], None],
    most: int | None = None,
) -> nn.Module:
    """The network after all epochs, or after `most` of them in this call.

    Every epoch starts from a random state of its own, so that it does not matter where a run was cut off.
    """
    learner = begun(stage, seed, checkpoint)
    first = len(learner.curve)
    for epoch in range(first, stage.epochs if most is None else min(stage.epochs, first + most)):
        torch.manual_seed(1000 * (seed + stage.seed) + epoch + 1)
        rng = np.random.default_rng([seed, stage.seed, epoch])
        learner.curve.append(epoch_loss(stage, data, learner, epoch, rng, told))
        keep(learner, checkpoint)
    return learner.network


def epoch_loss(
    stage: Stage,
    data: Clouds,
    learner: Learner,
    epoch: int,
    rng: np.random.Generator,
    told: Callable[[str], None],
) -> float:
    """The mean loss of an epoch, after it."""
    learner.network.train()
    losses: list[float] = []
    steps = steps_of(stage, len(data.labels))
    for step, batch in enumerate(batches(stage, data, steps, rng)):
        rate = stage.rate * schedule((epoch * steps + step) / (stage.epochs * steps))
        losses.append(step_loss(stage, learner, batch, rate))
        told(f"epoch {epoch + 1}/{stage.epochs}, step {step + 1}/{steps}, loss {np.mean(losses[-100:]):.4f}")
    return float(np.mean(losses))


def steps_of(stage: Stage, clouds: int) -> int:
    """Of an epoch, where there are so many clouds."""
    return max(1, min(EPOCH, clouds) // stage.batch)


def batches(stage: Stage, data: Clouds, steps: int, rng: np.random.Generator) -> Iterator[Batch]:
    """Those of an epoch."""
    order = rng.permutation(len(data.labels))
    for step in range(steps):
        yield drawn_batch(stage, data, order[step * stage.batch : (step + 1) * stage.batch], rng)


def schedule(done: float) -> float:
    """The share of the largest learning rate after this share of the steps."""
    if done < WARM:
        return 0.05 + 0.95 * done / WARM
    return 0.01 + 0.99 * (1.0 + math.cos(math.pi * (done - WARM) / (1.0 - WARM))) / 2.0


def step_loss(stage: Stage, learner: Learner, batch: Batch, rate: float) -> float:
    """The loss of a batch before a step of Adam that lowers it."""
    for group in learner.optimizer.param_groups:
        group["lr"] = rate
    loss = loss_of(stage, learner.network, batch)
    learner.optimizer.zero_grad()
    loss.backward()
    nn.utils.clip_grad_norm_(learner.network.parameters(), STEEPEST)
    learner.optimizer.step()
    return float(loss.detach())


def loss_of(stage: Stage, network: nn.Module, batch: Batch) -> torch.Tensor:
    """The method's loss, and for a PointNet what keeps its alignment of features near a rotation."""
    found = network(batch.inputs)
    if stage.kind is None:
        loss = functional.cross_entropy(found, batch.truth)
    else:
        loss = {"m3": m3_loss, "m4": m4_loss}[stage.method](stage.kind, found, batch.truth)
    return loss + ALIKE * network.unlike if isinstance(network, PointNet) else loss
