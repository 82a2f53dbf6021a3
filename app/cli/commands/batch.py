"""`primfit batch`: many clouds, the answer of each in a file of its own."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.names import ANSWER_PARTS

from ...bulk.places import is_remote
from .. import options as of
from ..status import BAD_INPUT, EXIT, INTERNAL_ERROR, INTERRUPTED, complain, refused, worst

if TYPE_CHECKING:
    from ..batch import Summary
    from ..plan import Plan

_GOES_ON = "the same command goes on from there"


def _folder(out: Path) -> Path:
    """Refuse a URL, in which a path has one slash less."""
    if is_remote(out.as_posix().replace(":/", "://", 1)):
        raise typer.BadParameter(
            "answers go into a folder, not to a URL; on a cluster into one that all its machines share"
        )
    return out


def batch(
    context: typer.Context,
    inputs: Annotated[
        list[str],
        typer.Argument(metavar="INPUT...", help="Files, and folders searched for clouds by their suffix."),
    ],
    out: Annotated[Path, typer.Option(help="Folder for the answers.", file_okay=False, callback=_folder)],
    format: Annotated[
        Literal["json", "shrec22", "parquet"],
        typer.Option(
            help="NAME.json; NAME_prediction.txt in the format of the SHREC 2022 track; or Parquet, a row a "
            "segment, in a run that goes on where it was broken off."
        ),
    ] = "json",
    workers: Annotated[
        int | None,
        typer.Option(
            min=1, show_default="one a core", help="Processes; any number of them gives the same answers."
        ),
    ] = None,
    executor: Annotated[
        Literal["local", "ray"],
        typer.Option(help="Processes of this machine, or of a Ray cluster, which give the same answers."),
    ] = "local",
    address: Annotated[
        str | None,
        typer.Option(
            metavar="HOST:PORT", help="Of the cluster.", show_default="one that runs here, or else a new one"
        ),
    ] = None,
    labels: of.Labels = None,
    kind: of.Kinds = None,
    classifier: of.Classifier = None,
    criterion: of.Criterion = None,
    max_error: of.MaxError = None,
    tolerance: of.Tolerance = None,
    seed: of.Seed = None,
    constraint: of.Constraint = None,
    initial_guess: of.InitialGuess = None,
    include: of.Include = None,
    nominal: of.Nominal = None,
    form_tolerance: of.FormTolerance = None,
    columns: of.Columns = None,
    missing: of.Missing = None,
    unit: of.Unit = None,
    step: Annotated[
        Path | None, typer.Option(help="Write all trimmed primitives to it, as one assembly.", dir_okay=False)
    ] = None,
    table: Annotated[
        Path | None, typer.Option(help="Write a row for each cloud to it, as CSV.", dir_okay=False)
    ] = None,
    report: Annotated[
        Path | None, typer.Option(help="Write a page about all clouds to it, as HTML.", dir_okay=False)
    ] = None,
) -> None:
    """Fit many clouds; each answer goes into a file of its own.

    With --labels the answer for each segment goes into NAME/LABEL.json. With --format parquet inputs may also
    be patterns, URLs, Parquet files and lists of inputs (@FILE); 'primfit table' reads the rows.

    Exit status: 0 when every input has its answer (whatever its status), 2 when one has not.
    """
    from ...engine.executors import check_executor, team_of
    from ...engine.ray_team import ClusterError
    from ...engine.team import LostWorkerError
    from ...readers.formats import SUFFIXES
    from ..batch import InterruptedRunError, run
    from ..gathered import Gathered
    from ..plan import CollisionError, plan

    options = of.checked(context.params)
    try:
        check_executor(executor, address)
    except InvalidOptionError as error:
        raise refused("--address", str(error)) from None
    size = workers or (os.cpu_count() or 1 if executor == "local" else None)
    files = {"step": step, "csv": table, "report": report}
    if format == "parquet":
        if any(files.values()):
            raise refused("--format", "--step, --table and --report are not for parquet: see primfit table")
        raise typer.Exit(_in_rows(inputs, out, options, labels, executor, size, address))
    try:
        planned = plan(inputs, out, format, labels)
    except CollisionError as error:
        complain("batch", str(error))
        raise typer.Exit(BAD_INPUT) from None
    if not planned.targets:
        complain("batch", f"no {' '.join(SUFFIXES)} file was found")
        raise typer.Exit(BAD_INPUT)
    gathered = Gathered({name: file for name, file in files.items() if file is not None})
    gathered.check(planned, options.get("include", ANSWER_PARTS))
    try:
        most = None if labels else len(planned.targets)
        team = team_of(executor, size, address, most=most)
        summary = run(planned, format, options, team, labels, gathered.gather)
    except OSError as error:
        why = "it is no folder" if isinstance(error, FileExistsError) else error.strerror or error
        complain(str(error.filename or out), f"cannot be written: {why}")
        raise typer.Exit(BAD_INPUT) from None
    except ImportError as error:
        raise refused("batch", str(error)) from None
    except (LostWorkerError, ClusterError) as error:
        complain("batch", f"{error}; answers up to then are in {out}")
        raise typer.Exit(INTERNAL_ERROR) from None
    except InterruptedRunError as error:
        complain("batch", f"{error}; answers are in {out}")
        raise typer.Exit(INTERRUPTED) from None
    statuses = [problem.exit_status for problem in summary.problems]
    if summary.n_clouds:
        statuses += gathered.write(summary.parts)
    _tell(summary, planned, out)
    raise typer.Exit(worst(statuses) if summary.n_clouds else BAD_INPUT)


def _in_rows(
    inputs: list[str],
    out: Path,
    options: Mapping[str, Any],
    labels: str | None,
    executor: Literal["local", "ray"],
    workers: int | None,
    address: str | None,
) -> int:
    """The exit status of a run that writes rows."""
    try:
        from ...bulk.parts import OtherRunError
        from ...bulk.run import LostTaskError
        from ...bulk.sources import GivenTwiceError
        from ...engine.executors import team_of
        from ...engine.ray_team import ClusterError
        from ..in_rows import InterruptedRowsError, answer_in_rows

        team = team_of(executor, workers, address, apart=True)
        return answer_in_rows(inputs, out, options, labels, team)
    except (ImportError, OtherRunError, GivenTwiceError) as error:
        raise refused("batch", str(error)) from None
    except OSError as error:
        complain(str(error.filename or out), f"{error.strerror or error}; {_GOES_ON}")
        return BAD_INPUT
    except (LostTaskError, ClusterError) as error:
        complain("batch", f"{error}; {_GOES_ON}")
        return INTERNAL_ERROR
    except InterruptedRowsError as error:
        complain("batch", f"{error}; {_GOES_ON}")
        return INTERRUPTED


def _tell(summary: "Summary", planned: "Plan", out: Path) -> None:
    """Say what has no answer and why, what was skipped, and how many there are of each status."""
    for problem in summary.problems:
        complain(problem.name, problem.message)
    for other in summary.skipped:
        complain(other.name, f"skipped, since it is no cloud: {other.message}")
    if planned.others:
        kinds = ", ".join(f"{n} {suffix}" for suffix, n in sorted(planned.others.items()))
        complain("batch", f"skipped by their suffixes: {kinds}")
    counts = [f"{summary.statuses[status]} {status}" for status in EXIT]
    counts.append(f"{len(summary.problems)} with a problem")
    if n_skipped := len(summary.skipped) + planned.others.total():
        counts.append(f"{n_skipped} skipped")
    print(f"{summary.n_clouds} clouds: {', '.join(counts)}; answers in {out}")
