"""Train the networks of the paper's methods:  python -m primfit.paper.training --seed 20220

Sixteen networks, one after the other in each of two processes, on one thread each. What is finished stands
with its card in --out and is not trained again; a network that was cut off goes on from its last checkpoint
under --cache. The same seed gives the same bytes on one machine and set of packages, however often it was cut
off. They learn from clouds of the seed and are measured on clouds of the seed + 1.
"""

import argparse
import os
import signal
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any

import torch

from primfit.models.weights import WeightsMismatchError, load, save

from ..method import DIRECTORY
from ..parts.stored import arrays_of, built, filled
from .clouds import Clouds, clouds
from .learning import EPOCH, learned
from .measuring import measured
from .stages import Stage, stages

SEED = 20220
CLOUDS = 30_000
VALIDATION = 2_500
CACHE = Path("build/paper")
QUICK = {"clouds": 200, "validation": 50, "epochs": 1}
"""Instead of all, to see that it works: the weights are of no use."""
EVERY = 2.0
"""Seconds between two lines of progress, at least."""


@dataclass(frozen=True)
class Run:
    """What the command asks for."""

    seed: int
    clouds: int
    validation: int
    out: Path
    cache: Path

    def command(self) -> str:
        """As the card names it."""
        return (
            f"python -m primfit.paper.training --seed {self.seed} --clouds {self.clouds} "
            f"--validation {self.validation}"
        )

    def recipe(self, stage: Stage) -> dict[str, Any]:
        """All that the weights depend on, beside the code and the seed."""
        return {"command": self.command(), **stage.recipe, "clouds": self.clouds, "epoch_clouds": EPOCH}


def finished(stage: Stage, run: Run) -> bool:
    """Whether its weights are there, made by this command."""
    try:
        _, card = load(stage.name, run.out)
    except WeightsMismatchError:
        return False
    return card.seed == run.seed and card.recipe == run.recipe(stage)


def trained(stage: Stage, run: Run) -> dict[str, Any]:
    """Train a network, measure what is stored of it, and write it with its card; the metrics."""
    torch.set_num_threads(1)
    data, validation = (
        _of(stage, clouds(seed, count, run.cache))
        for seed, count in ((run.seed, run.clouds), (run.seed + 1, run.validation))
    )
    checkpoint = run.cache / f"{stage.name}-{run.seed}-{run.clouds}-{stage.epochs}.pt"
    network = learned(stage, data, run.seed, checkpoint, progress(stage.name))
    arrays = arrays_of(network)
    metrics = {"benchmark": measured(stage, filled(built(stage.network), arrays), validation)}
    save(arrays, stage.name, run.recipe(stage), run.seed, metrics, run.out)
    return metrics


def _of(stage: Stage, data: Clouds) -> Clouds:
    return data if stage.kind is None else data.of(stage.kind)


def progress(name: str) -> Callable[[str], None]:
    """Tells how far a network is: on one line of a terminal, in lines of a file."""
    begin = last = time.monotonic()
    end = "\r" if sys.stderr.isatty() else "\n"
    every = EVERY if sys.stderr.isatty() else 10.0 * EVERY

    def told(text: str) -> None:
        nonlocal last
        if time.monotonic() - last >= every:
            last = time.monotonic()
            print(f"{name}: {text}, {last - begin:.0f} s ", end=end, file=sys.stderr, flush=True)

    return told


def train(run: Run, chosen: list[Stage], processes: int) -> None:
    """All networks that are not finished, so many at a time."""
    due = [stage for stage in chosen if not finished(stage, run)]
    for seed, count in ((run.seed, run.clouds), (run.seed + 1, run.validation)):
        clouds(seed, count, run.cache, processes)
    with ProcessPoolExecutor(processes, get_context("spawn"), max_tasks_per_child=1) as pool:
        begun = {pool.submit(trained, stage, run): stage for stage in due}
        for done in as_completed(begun):
            print(f"{begun[done].name}: {done.result()['benchmark']}", flush=True)


def stop(*_: object) -> None:
    """When this process is told to end, those that it began do so, too, and what waits is not begun."""
    for child in active_children():
        child.terminate()
    print("told to end; the same command goes on from the last checkpoints", file=sys.stderr, flush=True)
    os._exit(1)


def options() -> argparse.ArgumentParser:
    """The options of the command."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--clouds", type=int, default=CLOUDS, help="to learn from")
    parser.add_argument("--validation", type=int, default=VALIDATION, help="to measure on, from seed + 1")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="some of the networks")
    parser.add_argument("--processes", type=int, default=2, help="that train, and draw clouds")
    parser.add_argument("--out", type=Path, default=DIRECTORY)
    parser.add_argument("--cache", type=Path, default=CACHE, help="for clouds and checkpoints")
    parser.add_argument("--quick", action="store_true", help="an epoch of a few clouds, as a test")
    return parser


def main(arguments: list[str] | None = None) -> None:
    parser = options()
    given = parser.parse_args(arguments)
    known = {stage.name: stage for stage in stages()}
    if unknown := set(given.only or ()) - set(known):
        parser.error(f"--only: {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    chosen = [known[name] for name in given.only or known]
    signal.signal(signal.SIGTERM, stop)
    run = Run(given.seed, given.clouds, given.validation, given.out, given.cache)
    if given.quick:
        if run.out == DIRECTORY:
            parser.error("--quick wants an --out of its own")
        run = replace(run, clouds=QUICK["clouds"], validation=QUICK["validation"])
        chosen = [replace(stage, epochs=QUICK["epochs"]) for stage in chosen]
    train(run, chosen, given.processes)
