"""`primfit fit`: the clouds in a few files, their answers on standard output."""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from .. import options as of
from ..status import EXIT, complain, worst

if TYPE_CHECKING:
    from ..artifacts import Artifacts

ExportFile = Annotated[Path | None, typer.Option(help="Write the trimmed primitive to it.", dir_okay=False)]
ResidualFile = Annotated[
    Path | None, typer.Option(help="Write the signed residuals of all points to it.", dir_okay=False)
]


def fit(
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE...", help="Clouds of any format, also packed; '-' is standard input."),
    ],
    as_json: Annotated[
        bool, typer.Option("--json", help="One JSON object a line a file: the answer of POST /fit.")
    ] = False,
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
    step: ExportFile = None,
    glb: ExportFile = None,
    obj: ExportFile = None,
    stl: ExportFile = None,
    ply_mesh: ExportFile = None,
    csv_row: Annotated[
        Path | None, typer.Option(help="Write kind, parameters and errors to it, as one row.", dir_okay=False)
    ] = None,
    shrec22: Annotated[
        Path | None, typer.Option(help="Write the prediction of the SHREC 2022 track to it.", dir_okay=False)
    ] = None,
    residuals_npy: ResidualFile = None,
    residuals_csv: ResidualFile = None,
    residuals_ply: ResidualFile = None,
    residuals_las: ResidualFile = None,
    form: Annotated[
        Path | None, typer.Option(help="Write form errors and percentiles to it, as JSON.", dir_okay=False)
    ] = None,
    report: Annotated[
        Path | None, typer.Option(help="Write a report with pictures to it, one HTML file.", dir_okay=False)
    ] = None,
    unit: Annotated[
        Literal["mm", "m", "inch"],
        typer.Option(help="Of the coordinates, as STEP files and reports say it."),
    ] = "mm",
    chord_error: Annotated[
        float, typer.Option(help="Largest distance of meshes from the surface, as a share of its size.")
    ] = 1e-3,
    title: Annotated[str | None, typer.Option(help="Title of the report.")] = None,
    operator: Annotated[str | None, typer.Option(help="Who measured, as the report says it.")] = None,
    date: Annotated[str | None, typer.Option(help="When it was measured, as the report says it.")] = None,
) -> None:
    """Recognise and fit the cloud in each FILE.

    JSON is that of POST /fit, with its options if it holds any. With --labels each line of --json is that of
    POST /fit/batch.

    Exit status, the worst of the files: 0 fitted, 3 ambiguous, 4 no_fit, 2 bad input.
    After a bad file the others are still done. Exports are written of one FILE.
    """
    from ..artifacts import Artifacts

    options = of.checked(
        kind, classifier, criterion, max_error, tolerance, seed, constraint, initial_guess, include
    )
    exports = {"step": step, "glb": glb, "obj": obj, "stl": stl, "ply": ply_mesh, "csv": csv_row}
    exports |= {"shrec22": shrec22, "residuals_npy": residuals_npy, "residuals_csv": residuals_csv}
    exports |= {
        "residuals_ply": residuals_ply,
        "residuals_las": residuals_las,
        "form": form,
        "report": report,
    }
    about = {"title": title, "operator": operator, "date": date}
    artifacts = Artifacts.wanted(exports, files, labels, unit, chord_error, about, options.get("include"))
    raise typer.Exit(worst(_statuses(files, options, labels, as_json, artifacts)))


def _statuses(
    files: list[str],
    options: dict[str, Any],
    labels: str | None,
    as_json: bool,
    artifacts: "Artifacts | None",
) -> Iterator[int]:
    """The exit status of each answer, which is written before the next one is made."""
    from ...engine.answer import to_json
    from ..files import Problem

    show = _show()
    formats = () if artifacts is None else tuple(artifacts.files)
    for name, item, found in _answers(files, options, labels, formats):
        if isinstance(found, Problem):
            complain(found.name, found.message)
            yield found.exit_status
            continue
        fitted, answer = found
        if as_json:
            line = to_json(answer)
            sys.stdout.buffer.write(item.line("answer", line) if item else line + b"\n")
            sys.stdout.flush()
        else:
            show(name, answer)
        yield EXIT[answer["status"]]
        if artifacts is not None:
            yield artifacts.write(fitted)


def _show() -> Callable[[str, dict[str, Any]], None]:
    """Prints an answer for people."""
    from rich.console import Console

    from ..render import render

    console = Console(highlight=False)
    return lambda name, answer: console.print(render(name, answer))


def _answers(
    files: list[str], options: dict[str, Any], labels: str | None, formats: tuple[str, ...]
) -> Iterator[tuple[str, Any, Any]]:
    """What to call each answer, its item where there are segments, and what was recognised or a problem."""
    from ...engine.items import Item
    from ...engine.names import Ids, base_name
    from ...engine.team import Team
    from ..files import STDIN, Problem, answer_segments, fit_file

    if not labels:
        for name in files:
            yield name, None, fit_file(name, options, formats)
        return
    ids, whole, number = Ids(), None, 0
    with Team(1) as team:
        for source, answer in answer_segments(files, options, labels, team, lambda source: lambda made: made):
            if source.number != number:
                number = source.number
                whole = Item.of_file(None if source.name == STDIN else base_name(source.name), number, ids)
            assert whole is not None
            item = whole if source.label is None else whole.segment(source.label, ids)
            yield source.title, item, answer if isinstance(answer, Problem) else (None, answer)
