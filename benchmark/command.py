"""`primfit bench`, or `python -m primfit.benchmark`: run methods over case sets, and write the report."""

import argparse
import shlex
import sys
from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from primfit.synthetic import RECIPES

from . import coverage, drawing
from .batch import batch_action
from .cases import CASE_SETS, Case, CaseSet
from .methods import METHODS, NETWORKS, PEERS
from .options import make_parser
from .proofs import PROOFS
from .proofs.records import Key, ProofRecord, ProofsFile, prove_all
from .published import introductions, publish
from .real import MANIFEST, REAL, RealError, RealFolder, is_there
from .records import Record, RecordsFile
from .report import MissingMatplotlibError, NoRecordsError, write
from .report.added import draw_added
from .report.coverage import write_coverage
from .report.pictures import require_matplotlib
from .report.proofs import proven
from .runner import Children, MethodError, Work, begin, introduce, run
from .scaling.command import ACTIONS
from .scaling.records import RunError
from .service import BODIES, SIZES, busy, livez_line, measure, slowest_livez, table
from .serving import ServiceError
from .speed.command import speed_action, steps_action
from .speed.page import PageError
from .speed.timers import NameGoneError
from .summary import summary, wrong_line
from .track import TRACK, TrackError, TrackFolder

DEFAULT_METHOD = next(iter(METHODS))
BAD_INPUT, INTERRUPTED = 2, 130
INSTALL = "`make bench-peers` installs the peers"

EXPECTED = (
    MethodError,
    ServiceError,
    TrackError,
    RealError,
    NoRecordsError,
    MissingMatplotlibError,
    NameGoneError,
    PageError,
    RunError,
)
"""What ends the command with a sentence."""


def bench(arguments: Sequence[str] | None = None, program: str = "primfit bench") -> int:
    """The command with these arguments; returns its exit status."""
    actions = (run_action, report_action, service_action, coverage_action, proofs_action, drawing_action)
    parser = make_parser(program, *actions, steps_action, speed_action, batch_action, ACTIONS)
    options = parser.parse_args(arguments)
    if not hasattr(options, "action"):
        parser.print_help()
        return BAD_INPUT
    try:
        return int(options.action(options))
    except (*EXPECTED, OSError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        goes_on = f"; the same command goes on from {options.out}" if hasattr(options, "out") else ""
        print(f"\n{program}: interrupted{goes_on}", file=sys.stderr)
        return INTERRUPTED


def report_action(options: argparse.Namespace) -> int:
    path = write(RecordsFile(options.records), options.out)
    print(f"written: {path}, the other pages and images/ beside it")
    return 0


def service_action(options: argparse.Namespace) -> int:
    if options.picture:
        require_matplotlib()
    options.out.mkdir(parents=True, exist_ok=True)
    warning = busy()
    asked = (options.points or SIZES, options.format or tuple(BODIES))
    rows = list(measure(options.turns, options.seed, options.out / "service.log", *asked))
    livez = livez_line(slowest_livez(options.seed, options.out / "service.log"))
    print(table(rows), "", livez, warning, sep="\n")
    if options.picture:
        draw_added(rows, options.picture)
    return 0


def coverage_action(options: argparse.Namespace) -> int:
    require_matplotlib()
    laws = tuple(law for law in coverage.LAWS if law in (options.law or coverage.LAWS))
    found = coverage.measure(options.n, options.seed, options.processes, laws)
    command = f"primfit bench coverage --n {options.n} --seed {options.seed}"
    command += "".join(f" --law {shlex.quote(law)}" for law in laws if options.law)
    print(f"written: {write_coverage(found, command, options.out)} and images/ beside it")
    return 0


def proofs_action(options: argparse.Namespace) -> int:
    file = ProofsFile(options.out)
    asked = [
        (name, options.seed, case)
        for name, proof in PROOFS.items()
        if name in (options.set or PROOFS)
        for case in range(options.n or (proof.full if options.full else proof.small))
    ]
    left = file.begin(asked, options.restart)
    console = Console(highlight=False)
    count_up(file.append(prove_all(left, options.processes)), asked, left, console)
    wanted = set(asked)
    for line in proven([record for record in file.read() if record.key in wanted]):
        console.print(line, soft_wrap=True, markup=False)
    console.print(f"records: {file.path}")
    return 0


def drawing_action(options: argparse.Namespace) -> int:
    print(drawing.table([drawing.rate(name, options.seed, options.seconds) for name in RECIPES]))
    return 0


def run_action(options: argparse.Namespace) -> int:
    console = Console(highlight=False)
    if options.real and not is_there(options.real):
        console.print(f"left out: {options.real} holds no {MANIFEST}, so there are no real segments")
    works = plan(options)
    named = options.method or [DEFAULT_METHOD]
    names = list(dict.fromkeys([*named, *(PEERS if options.peers else [])]))
    options.out.mkdir(parents=True, exist_ok=True)
    file = RecordsFile(options.out)
    with Children(options.out / "methods.log", options.python) as child:
        methods = usable(introduce(child, names), named, console)
        told = introductions(works)
        done, stale = begin(file, works, methods | told, options.restart)
        if stale:
            console.print(f"{stale} records are dropped: the versions of their methods have changed")
        ran = run(child, file, works, methods, done, options.timeout)
        watch(ran, works, console, options.show_wrong)
    for record in publish(file, works, done):
        if options.show_wrong and not record.right:
            console.print(wrong_line(record), soft_wrap=True)
    asked = {(work.set, work.seed, name) for work in works for name in work.names}
    console.print(summary([r for r in file.read() if r.method in methods | told and r.key[:3] in asked]))
    console.print(f"records: {file.path}")
    return 0


def plan(options: argparse.Namespace) -> list[Work]:
    """The cases that are asked for; raises `TrackError` and `RealError`."""
    names = options.set or ([] if options.shrec22 or options.real else CASE_SETS)
    works = []
    for name, chosen in CASE_SETS.items():
        if name in names:
            count = options.n or (chosen.full if options.full else chosen.small)
            cases = [str(index) for index in range(count)]
            works.append(Work(name, options.seed, cases, partial(_draw, chosen, options.seed), chosen.own))
    if options.shrec22:
        folder = TrackFolder(options.shrec22)
        names = folder.names[: options.n]
        works.append(Work(TRACK, folder.fingerprint, names, folder.case, published=folder.published))
    if options.real and is_there(options.real):
        real = RealFolder(options.real)
        works.append(Work(REAL, real.fingerprint, real.names[: options.n], real.case))
    return works


def _draw(chosen: CaseSet, seed: int, name: str) -> Case:
    return chosen.draw(seed, int(name))


def usable(
    known: dict[str, dict[str, Any]], named: Sequence[str], console: Console
) -> dict[str, dict[str, Any]]:
    """The methods that are installed; raises `MethodError` where one that was named is not."""
    for name, told in known.items():
        if "missing" in told:
            remedy = "`make .venv-torch/.torch` installs torch" if name in NETWORKS else INSTALL
            sentence = f"{name} is not installed ({told['missing']}); {remedy}"
            if name in named:
                raise MethodError(sentence)
            console.print(f"left out: {sentence}")
    return {name: told for name, told in known.items() if "missing" not in told}


def count_up(
    records: Iterable[ProofRecord], asked: Sequence[Key], left: Sequence[Key], console: Console
) -> None:
    """A bar for each set, which moves as its records come."""
    columns = (TextColumn("{task.description:<15}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console) as progress:
        bars = {}
        for name in dict.fromkeys(name for name, *_ in asked):
            total, remain = (sum(key[0] == name for key in keys) for keys in (asked, left))
            bars[name] = progress.add_task(name, total=total, completed=total - remain, start=not remain)
        for record in records:
            progress.start_task(bars[record.set])
            progress.advance(bars[record.set])


def watch(
    ran: Iterable[tuple[Work, list[Record]]], works: Sequence[Work], console: Console, show_wrong: bool
) -> None:
    """Show what comes: a bar for each set, and what the first of the methods got right in this run."""
    columns = (TextColumn("{task.description:<15}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, TextColumn("{task.fields[right]}"), console=console) as progress:
        bars = {
            work.set: progress.add_task(work.set, total=len(work.names), right="", start=False)
            for work in works
        }
        right = dict.fromkeys(bars, 0)
        asked = dict.fromkeys(bars, 0)
        for work, records in ran:
            progress.start_task(bars[work.set])
            for record in records[:1]:
                right[work.set] += record.right
                asked[work.set] += 1
                told = f"{record.method}: {right[work.set]} of {asked[work.set]} right"
                progress.update(bars[work.set], right=told)
            for record in records:
                if show_wrong and not record.right:
                    progress.console.print(wrong_line(record), soft_wrap=True)
            progress.advance(bars[work.set])
