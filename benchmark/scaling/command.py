"""What `primfit bench scaling` does with its options."""

import argparse
from pathlib import Path

from rich.console import Console
from rich.progress import track

from ..service import busy
from .options import Action
from .records import Asked, RunRecord, told
from .sets import SegmentSet

WRONG = 1
"""The exit status where something is not as it should be."""

WORKERS = {"local": 2, "ray": 3}
AT = {"none": 0.0, "node": 0.5, "driver": 0.3}


def segments_action(options: argparse.Namespace) -> int:
    chosen = SegmentSet(options.folder / "segments", options.seed, options.n)
    missing, console = len(chosen.missing), Console(stderr=True)
    drawn = chosen.draw(options.processes)
    now = sum(1 for _ in track(drawn, "files", missing, console=console, transient=True))
    print(f"files: {len(chosen.files)}, of which {now} drawn now")
    points, size = sum(chosen.lengths()), sum(file.stat().st_size for file in chosen.files)
    print(f"{options.n:,} segments, {points:,} points, {size:,} bytes; listed in {chosen.listed()}")
    return 0


def run_action(options: argparse.Namespace) -> int:
    asked = asked_of(options)
    kept = options.folder / "runs" / f"{asked.name}.json"
    if kept.exists() and not options.again:
        print(f"made before: {kept}")
        print(told(RunRecord.read(kept)))
        return 0
    warning = busy("times mean little")
    from . import runs  # this one imports the app

    record = runs.run(asked, options.folder)
    print(told(record), f"written: {record.save(options.folder)}", sep="\n", end=f"{warning}\n")
    return 0


def compare_action(options: argparse.Namespace) -> int:
    from .compare import compared  # this one imports the app

    left, right = (kept(options.folder, name) for name in options.names)
    same, text = compared(left, right, options.folder)
    print(text)
    return 0 if same else WRONG


def asked_of(options: argparse.Namespace) -> Asked:
    workers = options.workers or WORKERS[options.executor]
    at = AT[options.kill] if options.at is None else options.at
    return Asked(options.n, options.seed, options.executor, workers, options.kill, at, options.turn)


def kept(folder: Path, name: str) -> RunRecord:
    """The record of a run; raises `FileNotFoundError`."""
    return RunRecord.read(folder / "runs" / f"{name}.json")


ACTIONS: dict[str, Action] = {
    "segments": segments_action,
    "run": run_action,
    "compare": compare_action,
}
