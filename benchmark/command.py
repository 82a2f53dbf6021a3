"""`primfit bench`, also as `python -m benchmark`: run methods over case sets, and write the report."""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from benchmark.cases import CASE_SETS
from benchmark.methods import METHODS, PEERS
from benchmark.records import Record, RecordsFile
from benchmark.report import MissingMatplotlibError, NoRecordsError, write
from benchmark.runner import (
    Child,
    MethodError,
    Work,
    begin,
    interpreter,
    introduce,
    run,
)
from benchmark.summary import summary, wrong_line
from benchmark.track import TRACK, NotATrackFolderError, TrackFolder

FOLDER = Path("build/bench")
BAD_INPUT, INTERRUPTED = 2, 130


def bench(arguments: Sequence[str] | None = None, program: str = "primfit bench") -> int:
    """The command with these arguments; returns its exit status."""
    parser = make_parser(program)
    options = parser.parse_args(arguments)
    if not hasattr(options, "action"):
        parser.print_help()
        return BAD_INPUT
    try:
        return int(options.action(options))
    except (MethodError, NotATrackFolderError, NoRecordsError, MissingMatplotlibError, OSError) as error:
        problem = str(error)
    except KeyboardInterrupt:
        print(f"\ninterrupted; the same command goes on from {options.out}", file=sys.stderr)
        return INTERRUPTED
    print(f"{program}: {problem}", file=sys.stderr)
    return BAD_INPUT


# -- the two actions ----------------------------------------------------------------------------------------


def run_action(options: argparse.Namespace) -> int:
    works = list(plan(options))
    names = tuple(dict.fromkeys([*(options.method or METHODS_BY_DEFAULT), *(PEERS if options.peers else ())]))
    options.out.mkdir(parents=True, exist_ok=True)
    file = RecordsFile(options.out)
    console = Console(highlight=False)
    python = options.python or interpreter(any(name in PEERS for name in names))
    with Child(python, options.out / "methods.log") as child:
        methods = usable(introduce(child, names), options.method or (), console)
        done, stale = begin(file, works, methods, options.restart)
        if stale:
            console.print(
                f"{stale} records are made anew: they were made with other versions of their method"
            )
        with progress_bar(console) as progress:
            watch(
                run(child, file, works, methods, done, options.timeout), works, progress, options.show_wrong
            )
    asked = {(work.set, work.seed, name) for work in works for name in work.names}
    records = [r for r in file.read() if r.method in methods and r.key[:3] in asked]
    console.print(summary(records))
    console.print(f"records: {file.path}; the report: {options.program} report --records {options.out}")
    return 0


def report_action(options: argparse.Namespace) -> int:
    path = write(RecordsFile(options.records), options.out)
    print(f"{path} and {path.parent / 'images'}")
    return 0


METHODS_BY_DEFAULT = (next(iter(METHODS)),)


def plan(options: argparse.Namespace) -> Sequence[Work]:
    """The cases that are asked for; raises `NotATrackFolderError`."""
    works = []
    names = options.set or ([] if options.shrec22 else list(CASE_SETS))
    for name in dict.fromkeys(names):
        chosen = CASE_SETS[name]
        count = options.n or (chosen.full if options.full else chosen.small)
        draw = chosen.draw
        cases = [str(index) for index in range(count)]
        works.append(
            Work(name, options.seed, cases, lambda case, draw=draw: draw(options.seed, int(case)))  # type: ignore[misc]
        )
    if options.shrec22:
        folder = TrackFolder(options.shrec22)
        works.append(Work(TRACK, 0, folder.names[: options.n], folder.case))
    return works


def usable(
    known: dict[str, dict[str, Any]], demanded: Sequence[str], console: Console
) -> dict[str, dict[str, Any]]:
    """The methods that are installed; raises `MethodError` where one that was named is not."""
    for name, told in known.items():
        if "missing" in told:
            sentence = f"{name} is not installed ({told['missing']}); `make bench-peers` installs the peers"
            if name in demanded:
                raise MethodError(sentence)
            console.print(f"left out: {sentence}")
    return {name: told for name, told in known.items() if "missing" not in told}


def progress_bar(console: Console) -> Progress:
    return Progress(
        TextColumn("{task.description:<16}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[right]}"),
        console=console,
    )


def watch(ran: Any, works: Sequence[Work], progress: Progress, show_wrong: bool) -> None:
    """Show what comes: a bar for each set, and what the first method got right of it in this run."""
    bars = {
        id(work): progress.add_task(work.set, total=len(work.names), right="", start=False) for work in works
    }
    counts = {id(work): [0, 0] for work in works}
    for work, records in ran:
        progress.start_task(bars[id(work)])
        for record in records:
            if show_wrong and not record.right:
                progress.console.print(wrong_line(record), soft_wrap=True)
        if records:
            right, asked = counts[id(work)] = [
                counts[id(work)][0] + records[0].right,
                counts[id(work)][1] + 1,
            ]
            progress.update(bars[id(work)], right=f"{records[0].method}: {right} of {asked} right")
        progress.advance(bars[id(work)])


# -- the options --------------------------------------------------------------------------------------------


def make_parser(program: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=program,
        description="Measure primfit and what others make on the same clouds, and write the report.",
        epilog=f"""examples:
  {program} run                              primfit on small sets
  {program} run --set shrec --n 500 --seed 7 --method primfit --method primfit-knn
  {program} run --shrec22 DIR                a folder in the layout of the SHREC 2022 track
  {program} run --full --peers               everything, in a few hours; goes on where it was cut off
  {program} report                           tables and pictures from the records

`{program} run --help` lists the sets and the methods. docs/benchmarking.md explains them.""",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    actions = parser.add_subparsers(title="actions", metavar="run | report")
    _add_run(actions, program)
    _add_report(actions, program)
    return parser


def _add_run(actions: Any, program: str) -> None:
    sets = "\n".join(
        f"  {name:16} {s.description.title} ({s.small} clouds; full: {s.full})"
        for name, s in CASE_SETS.items()
    )
    methods = "\n".join(f"  {name}" for name in METHODS)
    parser = actions.add_parser(
        "run",
        help="run methods over case sets and store a record for each cloud",
        description="Run methods over case sets and store a record for each cloud. A run that was cut off goes on.",
        epilog=f"sets:\n{sets}\n\nmethods (the first is the default):\n{methods}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(action=run_action, program=program)
    parser.add_argument(
        "--set", action="append", choices=CASE_SETS, metavar="NAME", help="a set (repeatable; all by default)"
    )
    parser.add_argument(
        "--shrec22", type=Path, metavar="DIR", help="a folder in the layout of the SHREC 2022 track"
    )
    parser.add_argument(
        "--method", action="append", choices=METHODS, metavar="NAME", help="a method (repeatable)"
    )
    parser.add_argument("--peers", action="store_true", help="all methods of others that are installed, too")
    sizes = parser.add_mutually_exclusive_group()
    sizes.add_argument("--n", type=whole(1), metavar="N", help="the first N clouds of each set")
    sizes.add_argument("--full", action="store_true", help="large sets instead of small ones")
    parser.add_argument("--seed", type=seed, default=1, metavar="S", help="of all clouds (default 1)")
    parser.add_argument(
        "--timeout", type=seconds, default=60.0, metavar="S", help="seconds a cloud (default 60)"
    )
    parser.add_argument(
        "--out", type=Path, default=FOLDER, metavar="DIR", help=f"folder of the records (default {FOLDER})"
    )
    parser.add_argument("--restart", action="store_true", help="make the records anew that are asked for")
    parser.add_argument("--show-wrong", action="store_true", help="print a line for each wrong answer")
    parser.add_argument(
        "--python",
        type=Path,
        metavar="FILE",
        help="interpreter of the methods (default: .venv-peers, or this)",
    )


def _add_report(actions: Any, program: str) -> None:
    parser = actions.add_parser(
        "report",
        help="write benchmark.md and its pictures from the records",
        description="Write benchmark.md and images/benchmark-*.png from the records; nothing is measured.",
    )
    parser.set_defaults(action=report_action, program=program)
    parser.add_argument(
        "--records",
        type=Path,
        default=FOLDER,
        metavar="DIR",
        help=f"folder of the records (default {FOLDER})",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=FOLDER / "report",
        metavar="DIR",
        help=f"folder of the report (default {FOLDER / 'report'})",
    )


LEARNT = range(2022, 2025)
"""Seeds of the clouds that the shipped classifiers were trained, calibrated and scored on."""


def whole(least: int) -> Callable[[str], int]:
    """A parser of whole numbers from `least` on."""

    def parse(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"is {text}, not a whole number from {least} on")
        return int(text)

    return parse


def seed(text: str) -> int:
    value = whole(0)(text)
    if value in LEARNT:
        raise argparse.ArgumentTypeError(
            f"is {value}; the shipped classifiers have seen clouds of the seeds {LEARNT[0]} to {LEARNT[-1]}"
        )
    return value


def seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value <= 86400.0:
        raise argparse.ArgumentTypeError(f"is {text}, not a number of seconds above 0 and up to 86400")
    return value
