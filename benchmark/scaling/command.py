"""What `primfit bench scaling` does with its options."""

import argparse
from pathlib import Path

from rich.console import Console
from rich.progress import track

from ..service import busy
from ..sources import ROOT
from ..speed import page
from . import tables
from .model import Parameters
from .options import Action
from .records import Asked, RunError, RunRecord, records, told
from .sets import SegmentSet

PAGE = ROOT / "docs" / "scaling.md"

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


def runs_action(options: argparse.Namespace) -> int:
    found = records(options.folder)
    if not found:
        raise RunError(f"no run is kept in {options.folder}")
    _show("runs", tables.runs_table(found), options.write)
    return 0


def scan_action(options: argparse.Namespace) -> int:
    from . import scan  # this one imports the app

    chosen = scan.Scan(options.folder / f"scan-{options.n}", options.n, options.points, options.seed)
    chosen.draw()
    warning = busy("times mean little")
    record = scan.measured(chosen)
    print(f"written: {record.save(chosen.folder)}{warning}")
    _show("scan", scan.told(record), options.write)
    return 0 if record.answers == record.segments else WRONG


def parameters_action(options: argparse.Namespace) -> int:
    from .parameters import measured

    parameters = measured(records(options.folder), options.folder)
    print(f"written: {parameters.save(options.parameters)}")
    _show("parameters", tables.parameters_table(parameters), options.write)
    return 0


def predict_action(options: argparse.Namespace) -> int:
    from .predict import predicted

    prediction = predicted(asked_of(options), options.folder, Parameters.read(options.parameters))
    nine = f"{prediction.low} to {prediction.high} s in nine of ten"
    print(f"{prediction.asked.name}: {prediction.wall} s, {nine}")
    print(f"written: {prediction.save(options.folder)}")
    return 0


def verdict_action(options: argparse.Namespace) -> int:
    from .predict import verdicts

    right, text = verdicts(options.folder, records(options.folder))
    _show("verdict", text, options.write)
    return 0 if right else WRONG


def simulate_action(options: argparse.Namespace) -> int:
    from . import fleets

    parameters = Parameters.read(options.parameters)
    questions = fleets.sizes(options.largest) + fleets.worlds(min(options.largest, 10**8), 100)
    answers = fleets.answered(questions, parameters, options.seed, options.processes)
    console = Console(stderr=True)
    found = list(track(answers, "simulations", len(questions), console=console, transient=True))
    sizes = [pair for pair in found if not pair[0].label]
    about = f"{min(options.largest, 10**8):,} segments on 100 nodes:"
    worlds = fleets.world_table([pair for pair in found if pair[0].label])
    knee = fleets.knee(parameters, fleets.pool(options.seed), sizes)
    _show("simulate", f"{fleets.table(sizes)}\n\n{knee}\n\n{about}\n\n{worlds}", options.write)
    return 0


def _show(part: str, text: str, write: bool) -> None:
    """Print a part of the page, or write it there."""
    print(text)
    if write:
        page.write(f"scaling {part}", text, f"primfit bench scaling {part}", PAGE)
        print(f"written: {PAGE}")


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
    "runs": runs_action,
    "scan": scan_action,
    "parameters": parameters_action,
    "predict": predict_action,
    "verdict": verdict_action,
    "simulate": simulate_action,
}
