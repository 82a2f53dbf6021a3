"""How long the networks take to train:  python -m primfit.paper.training.timing [SECONDS]

For each of the sixteen, steps of training on one thread for so many seconds (5), and from these the minutes
for all of its steps: what comes between, reading clouds and writing checkpoints, is seconds. Run it while
nothing else runs; on two cores all of them take half of the sum.
"""

import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import torch

from primfit.models.rough import KINDS

from .batches import Batch
from .clouds import Clouds, clouds
from .learning import batches, begun, step_loss, steps_of
from .running import CLOUDS, SEED
from .stages import Stage, stages

SECONDS = 5.0
DRAWN = 500
"""Clouds that the steps are made with."""


def minutes(stage: Stage, data: Clouds, seconds: float) -> float:
    """For all steps of a network, by those that are done in so many seconds after the first."""
    learner = begun(stage, SEED, Path("no such checkpoint"))
    learner.network.train()
    steps = forever(stage, data if stage.kind is None else data.of(stage.kind))
    step_loss(stage, learner, next(steps), stage.rate)
    done, taken, begin = 0, 0.0, time.perf_counter()
    while taken < seconds:
        step_loss(stage, learner, next(steps), stage.rate)
        done, taken = done + 1, time.perf_counter() - begin
    return taken / done * all_steps(stage) / 60.0


def forever(stage: Stage, data: Clouds) -> Iterator[Batch]:
    """Batches of these clouds."""
    rng = np.random.default_rng(0)
    while True:
        yield from batches(stage, data, steps_of(stage, len(data.labels)), rng)


def all_steps(stage: Stage) -> int:
    """Of the training of a network."""
    return stage.epochs * steps_of(stage, CLOUDS if stage.kind is None else CLOUDS // len(KINDS))


def main(seconds: float) -> None:
    torch.set_num_threads(1)
    with tempfile.TemporaryDirectory() as folder:
        data = clouds(SEED, DRAWN, Path(folder), 1)
    taken = {}
    for stage in stages():
        taken[stage.name] = minutes(stage, data, seconds)
        print(f"{stage.name}: {all_steps(stage):,} steps, {taken[stage.name]:.0f} minutes", flush=True)
    print(f"together: {sum(taken.values()) / 60.0:.1f} hours on one core")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else SECONDS)
