"""What `primfit bench steps` and `primfit bench speed` do with their options."""

import argparse
from collections.abc import Iterable, Iterator

from rich.console import Console
from rich.progress import track

from ..methods import PEERS
from ..runner import interpreter
from ..service import busy
from . import page, race

SLOW = 1
"""The exit status where a step has become slower."""


def steps_action(options: argparse.Namespace) -> int:
    # Not for the other actions: this one imports the app.
    from . import steps

    measured = steps.measure(options.n, options.seed)
    command = f"primfit bench steps --n {options.n} --seed {options.seed}"
    _show("steps", steps.section(measured), command, options.write)
    if options.keep:
        steps.keep(measured)
        print(f"kept: {steps.KEPT}")
    slower = steps.slower(measured) if options.compare else []
    print(*slower, sep="\n", end="\n" if slower else "")
    if slower:
        print(busy("others slow down memory and caches, too, so ask again when it is not"))
    if options.compare and not slower:
        print(f"no step takes more than {steps.SLOWER:g} times what was kept")
    return SLOW if slower else 0


def speed_action(options: argparse.Namespace) -> int:
    options.out.mkdir(parents=True, exist_ok=True)
    python = options.python or interpreter(PEERS[0])
    sizes = [size for size in race.SIZES if size <= options.largest]
    log = options.out / "methods.log"
    run = race.run(options.n, options.seed, python, log, options.real, sizes, _watched)
    real = " --real DIR" if options.real else ""
    command = f"primfit bench speed --n {options.n} --seed {options.seed}{real}"
    _show("speed", race.section(run), command, options.write)
    return 0


def _watched(laps: Iterator[race.Lap], count: int) -> Iterable[race.Lap]:
    return track(laps, "clouds", count, console=Console(stderr=True), transient=True)


def _show(part: str, text: str, command: str, write: bool) -> None:
    """Print a part of the page, or write it there."""
    if write:
        page.write(part, text, command)
        print(f"written: {page.PAGE}")
    else:
        print(text)
