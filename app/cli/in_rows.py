"""`primfit batch --format parquet`: a row a segment, in a run that goes on where it was broken off."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from ..bulk.parts import Part, Run
from ..bulk.rows import PROBLEM, schema
from ..bulk.run import run
from ..bulk.sources import references, stands_on
from ..bulk.tasks import Task, seconds, tasks
from ..engine.executors import AnyTeam
from .status import BAD_INPUT, EXIT, complain


class InterruptedRowsError(RuntimeError):
    """Ctrl-C; the message says how much is done."""


def answer_in_rows(
    inputs: Sequence[str],
    out: Path,
    options: Mapping[str, Any],
    labels: str | None,
    team: AnyTeam,
) -> int:
    """Answer every segment of the inputs, and say how many there are of each status; the exit status.

    Raises
    ------
    OtherRunError
        The folder belongs to another run.
    ImportError
        pyarrow is missing.
    GivenTwiceError
        An input is named twice.
    OSError
        Rows cannot be written, or inputs cannot be read for now.
    LostTaskError, ClusterError
        Processes cannot keep alive, or there is no cluster.
    InterruptedRowsError
        Ctrl-C was pressed.
    """
    schema()  # without pyarrow nothing is begun
    others: Counter[str] = Counter()
    columns = options.get("columns")
    asked = {"inputs": list(inputs), "folder": stands_on(inputs), "labels": labels, "columns": columns}
    # Other machines, too, find the folder by its whole name.
    begun = Run.begin(
        out.absolute(),
        asked,
        options,
        lambda scratch: tasks(references(inputs, labels, columns, str(scratch), others)),
    )
    try:
        if len(begun.done) < begun.plan.tasks:
            with team, _progress(begun) as told:
                run(begun, team, options, told)
    except KeyboardInterrupt:
        raise InterruptedRowsError(_so_far(begun)) from None
    finally:
        begun.end()
    return _tell(begun, others, out)


@contextmanager
def _progress(begun: Run) -> Iterator[Callable[[Task, Part], None]]:
    """A bar on a terminal: what is done of the segments and points, and the time left."""
    terminal, plan = Console(stderr=True), begun.plan
    columns = (
        TextColumn("fitting"),
        BarColumn(),
        TextColumn("{task.fields[done]}"),
        TimeRemainingColumn(elapsed_when_finished=True),
    )
    segments = sum(part.rows for part in begun.done.values())
    points = sum(part.points for part in begun.done.values())
    with Progress(*columns, console=terminal, disable=not terminal.is_terminal) as progress:
        bar = progress.add_task("fitting", total=seconds(plan.segments, plan.points), done="")
        progress.update(bar, completed=seconds(segments, points))

        def told(_: Task, part: Part) -> None:
            nonlocal segments, points
            segments, points = segments + part.rows, points + part.points
            done = f"{segments:,} of {plan.segments:,} segments"
            done += f", {_short(points)} of {_short(plan.points)} points"
            progress.update(bar, completed=seconds(segments, points), done=done)

        yield told


def _short(number: int) -> str:
    return f"{number / 1e6:,.1f} million" if number >= 1e6 else f"{number:,}"


def _so_far(begun: Run) -> str:
    done = sum(part.rows for part in begun.done.values())
    return f"{done} of {begun.plan.segments} segments done"


def _tell(begun: Run, others: Counter[str], out: Path) -> int:
    """Say how many there are of each status, and what was skipped."""
    if others:
        complain(
            "batch",
            f"skipped by their suffixes: {', '.join(f'{n} {of}' for of, n in sorted(others.items()))}",
        )
    statuses, n_segments = begun.statuses, begun.plan.segments
    if not n_segments:
        complain("batch", "no segment was found")
        return BAD_INPUT
    counts = [f"{statuses[status]} {status}" for status in EXIT]
    counts.append(f"{statuses[PROBLEM]} with a problem")
    print(f"{n_segments} segments: {', '.join(counts)}; rows in {out}")
    if statuses[PROBLEM]:
        complain(
            "batch", f"why not: primfit table {out} --where \"status = '{PROBLEM}'\" --columns id,message"
        )
        return BAD_INPUT
    return 0
