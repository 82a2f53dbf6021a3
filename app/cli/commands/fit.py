"""`primfit fit`: the clouds in a few files, their answers on standard output."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from primfit.fitting import names

from .. import options as of
from ..status import EXIT, complain, worst

if TYPE_CHECKING:
    from ..artifacts import Artifacts

TO_WRITE = "Files to write (of one FILE)"


def _about(help: str) -> Any:
    """An option of a file that is written."""
    return typer.Option(help=help, rich_help_panel=TO_WRITE)


def _file(contents: str) -> Any:
    """The option of a file that is written beside the answer; `contents` says what goes into it."""
    return typer.Option(help=f"Write {contents}.", dir_okay=False, rich_help_panel=TO_WRITE)


def fit(
    context: typer.Context,
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE...",
            help="Clouds of any format, also packed, or requests in JSON; '-' is standard input.",
        ),
    ],
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON, a line for each answer: that of POST /fit.")
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
    nominal: of.Nominal = None,
    form_tolerance: of.FormTolerance = None,
    columns: of.Columns = None,
    missing: of.Missing = None,
    unit: of.Unit = None,
    step: Annotated[Path | None, _file("the trimmed primitive as a surface for CAD (STEP)")] = None,
    glb: Annotated[Path | None, _file("a mesh of the primitive for viewers (binary glTF)")] = None,
    obj: Annotated[Path | None, _file("a mesh of the primitive as text (Wavefront OBJ)")] = None,
    stl: Annotated[Path | None, _file("a mesh of the primitive for printing (binary STL)")] = None,
    ply_mesh: Annotated[Path | None, _file("a mesh of the primitive as binary PLY")] = None,
    csv_row: Annotated[Path | None, _file("kind, parameters and errors as one row of CSV")] = None,
    shrec22: Annotated[Path | None, _file("the prediction in the format of the SHREC 2022 track")] = None,
    residuals_npy: Annotated[Path | None, _file("the signed residuals as an array for NumPy")] = None,
    residuals_csv: Annotated[Path | None, _file("x, y, z, residual and inlier of each point as CSV")] = None,
    residuals_ply: Annotated[Path | None, _file("the points with their residuals as PLY, in colors")] = None,
    residuals_las: Annotated[Path | None, _file("the points with their residuals as LAS")] = None,
    form: Annotated[Path | None, _file("form errors and percentiles of the residuals as JSON")] = None,
    report: Annotated[Path | None, _file("a report with pictures, one HTML file")] = None,
    chord_error: Annotated[
        float,
        typer.Option(
            help="Largest distance of meshes from the surface, as a share of its size.",
            rich_help_panel=TO_WRITE,
        ),
    ] = 1e-3,
    export_kind: Annotated[
        names.KindName | None,
        typer.Option(
            help="Which kind of an ambiguous answer is written; by default the first.",
            rich_help_panel=TO_WRITE,
        ),
    ] = None,
    title: Annotated[str | None, _about("Title of the report.")] = None,
    operator: Annotated[
        str | None, typer.Option(help="Who measured, as the report says it.", rich_help_panel=TO_WRITE)
    ] = None,
    date: Annotated[
        str | None,
        typer.Option(help="When it was measured, as the report says it.", rich_help_panel=TO_WRITE),
    ] = None,
) -> None:
    """Fit the cloud in each FILE and print the answer.

    Folders, and many files, are for 'primfit batch'. With --labels each segment has an answer of its own.

    Exit status, the worst of the files: 0 fitted, 3 ambiguous, 4 no_fit, 2 bad input. After a bad file the
    others are still done.
    """
    from ..artifacts import Artifacts

    options = of.checked(context.params)
    exports = {"step": step, "glb": glb, "obj": obj, "stl": stl, "ply": ply_mesh, "csv": csv_row}
    exports |= {"shrec22": shrec22, "residuals_npy": residuals_npy, "residuals_csv": residuals_csv}
    exports |= {
        "residuals_ply": residuals_ply,
        "residuals_las": residuals_las,
        "form": form,
        "report": report,
    }
    how: dict[str, Any] = {"chord_error": chord_error, "export_kind": export_kind}
    how |= {"title": title, "operator": operator, "date": date}
    artifacts = Artifacts.wanted(exports, files, labels, how, options.get("include"))
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
    from ..render import show

    formats = () if artifacts is None else tuple(artifacts.files)
    for name, item, found in _answers(files, options, labels, formats):
        if isinstance(found, Problem):
            complain(found.name, found.message)
            yield found.exit_status
            continue
        fitted, answer = found
        # Before the answer is printed: whoever reads it may leave early.
        if artifacts is not None:
            yield artifacts.write(fitted)
        if as_json:
            line = to_json(answer)
            sys.stdout.buffer.write(item.line("answer", line) if item else line + b"\n")
            sys.stdout.flush()
        else:
            show(name, answer)
        yield EXIT[answer["status"]]


def _answers(
    files: list[str], options: dict[str, Any], labels: str | None, formats: tuple[str, ...]
) -> Iterator[tuple[str, Any, Any]]:
    """What to call each answer, its item where there are segments, and what was recognized or a problem."""
    from ...engine.items import Item
    from ...engine.names import Ids, base_name
    from ...engine.team import Team
    from ..files import Problem, answer_segments, fit_file
    from ..identity import STDIN

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
            yield source.title, item, answer if isinstance(answer, Problem) else (None, answer[1])
