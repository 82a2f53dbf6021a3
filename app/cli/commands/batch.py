"""`primfit batch`: many clouds, the answer of each in a file of its own."""

import os
from pathlib import Path
from typing import Annotated, Literal

import typer

from .. import options as of
from ..status import BAD_INPUT, EXIT, INTERNAL_ERROR, INTERRUPTED, complain, worst


def batch(
    inputs: Annotated[
        list[str],
        typer.Argument(metavar="INPUT...", help="Files, and folders searched for clouds by their suffix."),
    ],
    out: Annotated[Path, typer.Option(help="Folder for the answers.", file_okay=False)],
    format: Annotated[
        Literal["json", "shrec22"],
        typer.Option(help="NAME.json, or NAME_prediction.txt in the format of the SHREC 2022 track."),
    ] = "json",
    workers: Annotated[
        int,
        typer.Option(
            min=1, show_default="one a core", help="Processes; any number of them gives the same answers."
        ),
    ] = os.cpu_count() or 1,
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
) -> None:
    """Fit many clouds; each answer goes into a file of its own.

    With --labels the answer for each segment goes into NAME/LABEL.json.

    Exit status: 0 when every input has its answer (whatever its status), 2 when one has not.
    """
    from ...engine.team import LostWorkerError
    from ..batch import SUFFIXES, CollisionError, InterruptedRunError, plan, run

    options = of.checked(
        kind,
        classifier,
        criterion,
        max_error,
        tolerance,
        seed,
        constraint,
        initial_guess,
        include,
        nominal,
        form_tolerance,
        columns,
        missing,
        unit,
    )
    try:
        targets = plan(inputs, out, format, labels)
    except CollisionError as error:
        complain("batch", str(error))
        raise typer.Exit(BAD_INPUT) from None
    if not targets:
        complain("batch", f"no {' '.join(SUFFIXES)} file was found")
        raise typer.Exit(BAD_INPUT)
    try:
        summary = run(targets, format, options, workers, labels)
    except OSError as error:
        why = "it is no folder" if isinstance(error, FileExistsError) else error.strerror or error
        complain(str(error.filename or out), f"cannot be written: {why}")
        raise typer.Exit(BAD_INPUT) from None
    except LostWorkerError as error:
        complain("batch", f"{error}; answers up to then are in {out}")
        raise typer.Exit(INTERNAL_ERROR) from None
    except InterruptedRunError as error:
        complain("batch", f"{error}; answers are in {out}")
        raise typer.Exit(INTERRUPTED) from None
    for problem in summary.problems:
        complain(problem.name, problem.message)
    counts = ", ".join(f"{summary.statuses[status]} {status}" for status in EXIT)
    print(f"{summary.n_clouds} clouds: {counts}, {len(summary.problems)} with a problem; answers in {out}")
    raise typer.Exit(worst(problem.exit_status for problem in summary.problems))
