"""`primfit` on the command line. What a command needs is imported when it runs: `primfit --help` is quick."""

import os
import sys
from collections.abc import Callable, Iterator
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from primfit.fitting import names
from primfit.models.names import CLASSIFIER, ClassifierName

if TYPE_CHECKING:
    from ..exports import ExportOptions, Fitted

# As in the service: one thread a process, so that every way in gives the same numbers.
for _threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")

# Exit status: of several files the worst decides, in this order.
EXIT = {"fitted": 0, "ambiguous": 3, "no_fit": 4}
BAD_INPUT = 2
INTERNAL_ERROR = 1
BADNESS = (*EXIT.values(), BAD_INPUT, INTERNAL_ERROR)

# Options that are lists or objects, and the flags that are repeated for them.
FLAGS = {"kinds": "kind", "constraints": "constraint"}


# Typer takes lists of an enum, not of a Literal.
Kind = StrEnum("Kind", [(kind, kind) for kind in names.KINDS])  # type: ignore[misc]
Kinds = Annotated[
    list[Kind] | None, typer.Option("--kind", help="Allow this kind (repeatable); all of them by default.")
]
Classifier = Annotated[
    ClassifierName | None,
    typer.Option(help="Who ranks the kinds; with 'none' all are tried.", show_default=CLASSIFIER),
]
Criterion = Annotated[
    names.Criterion | None,
    typer.Option(
        help="What the parameters minimise: 'robust' rejects outliers, 'least_squares' counts every point "
        "alike; the others are M-estimators, the minimum zone, and spheres or cylinders with all points "
        "inside or outside.",
        show_default=names.CRITERION,
    ),
]
MaxError = Annotated[
    float | None,
    typer.Option(
        help="Largest accepted mean distance of the inliers, as a share of the bounding-box diagonal; "
        "by default it follows from the noise of the cloud."
    ),
]
Tolerance = Annotated[
    float | None,
    typer.Option(
        help="What counts as no deviation, in the unit of the cloud: kinds that agree within it are equal, "
        "and the simplest is answered; a smooth deviation within it never leads to 'no_fit'. By default none."
    ),
]
Constraint = Annotated[
    list[str] | None,
    typer.Option(
        "--constraint",
        metavar="NAME=VALUE",
        help="What is known (repeatable): radius=5, radius=4..6, axis=0,0,1, axis=0,0,1@0.05 (radians), "
        "center=1,2,3; also major_radius, minor_radius, half_angle, normal, apex, point.",
    ),
]
InitialGuess = Annotated[
    str | None,
    typer.Option(metavar="JSON", help="A primitive, as in an answer, that joins the starts of its kind."),
]
Labels = Annotated[
    str | None,
    typer.Option(
        metavar="COLUMN",
        help="Fit each segment of a file: the points of one label in this column; 'auto' looks for a column "
        "of a usual name.",
    ),
]
ExportFile = Annotated[Path | None, typer.Option(help="Write the trimmed primitive to it.", dir_okay=False)]
ResidualFile = Annotated[
    Path | None, typer.Option(help="Write the signed residuals of all points to it.", dir_okay=False)
]
Seed = Annotated[int | None, typer.Option(help="Seed of every random choice.", show_default=str(names.SEED))]

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Which geometric primitive is this 3D point cloud, and with which parameters?",
)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"primfit {version('primfit')}")
        raise typer.Exit


@app.callback()
def _primfit(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None: ...


@app.command()
def fit(
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE...", help="Clouds of any format, also packed; '-' is standard input."),
    ],
    as_json: Annotated[
        bool, typer.Option("--json", help="One JSON object a line a file: the answer of POST /fit.")
    ] = False,
    labels: Labels = None,
    kind: Kinds = None,
    classifier: Classifier = None,
    criterion: Criterion = None,
    max_error: MaxError = None,
    tolerance: Tolerance = None,
    seed: Seed = None,
    constraint: Constraint = None,
    initial_guess: InitialGuess = None,
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
) -> None:
    """Recognise and fit the cloud in each FILE.

    JSON is that of POST /fit, with its options if it holds any. With --labels each line of --json is that of
    POST /fit/batch.

    Exit status, the worst of the files: 0 fitted, 3 ambiguous, 4 no_fit, 2 bad input.
    After a bad file the others are still done. Exports are written of one FILE.
    """
    from rich.console import Console

    from ..engine.answer import to_json
    from .files import Problem
    from .render import render

    options = _options(kind, classifier, criterion, max_error, tolerance, seed, constraint, initial_guess)
    named = {"step": step, "glb": glb, "obj": obj, "stl": stl, "ply": ply_mesh, "csv": csv_row}
    named |= {"shrec22": shrec22, "residuals_npy": residuals_npy, "residuals_csv": residuals_csv}
    named |= {"residuals_ply": residuals_ply, "residuals_las": residuals_las, "form": form, "report": report}
    exports = {name: file for name, file in named.items() if file is not None}
    export_options = _export_options(files, labels, exports, unit, chord_error) if exports else None
    console = Console(highlight=False)
    worst = 0
    for name, item, found in _answers(files, options, labels):
        if isinstance(found, Problem):
            _complain(found.name, found.message)
            worst = _worse(worst, found.exit_status)
            continue
        fitted, answer = found
        if as_json:
            line = to_json(answer)
            sys.stdout.buffer.write(item.line("answer", line) if item else line + b"\n")
            sys.stdout.flush()
        else:
            console.print(render(name, answer))
        worst = _worse(worst, EXIT[answer["status"]])
        if export_options is not None:
            for format, file in exports.items():
                worst = _worse(worst, _export(fitted, format, file, export_options))
    raise typer.Exit(worst)


def _answers(files: list[str], options: dict[str, Any], labels: str | None) -> Iterator[tuple[str, Any, Any]]:
    """What to call each answer, its item where there are segments, and what was recognised or a problem."""
    from .files import Problem, answer_segments, fit_file

    if not labels:
        for name in files:
            yield name, None, fit_file(name, options)
        return
    for source, answer in answer_segments(files, options, labels, workers=1):
        yield source.title, source.item, answer if isinstance(answer, Problem) else (None, answer)


def _export_options(
    files: list[str], labels: str | None, exports: dict[str, Path], unit: str, chord_error: float
) -> "ExportOptions":
    """Refuse what cannot be exported before anything is fitted."""
    from primfit.fitting.errors import InvalidOptionError

    from ..exports import ExportOptions

    if len(files) > 1 or labels:
        several = "the segments of a file" if labels else str(len(files))
        _complain("fit", f"exports are written of one FILE, not of {several}")
        raise typer.Exit(BAD_INPUT)
    taken = {Path(files[0]).resolve(): "the input"}
    for format, file in exports.items():
        if file.resolve() in taken:
            _complain(str(file), f"the export {format} would overwrite {taken[file.resolve()]}")
            raise typer.Exit(BAD_INPUT)
        taken[file.resolve()] = f"the export {format}"
    try:
        return ExportOptions(unit, chord_error)  # type: ignore[arg-type]
    except InvalidOptionError as error:
        _complain(f"--{error.field.replace('_', '-')}", str(error))
        raise typer.Exit(BAD_INPUT) from None


def _export(fitted: "Fitted", format: str, file: Path, options: "ExportOptions") -> int:
    """Write one artefact; the exit status."""
    from ..exports import FORMATS, NothingToExportError

    try:
        file.write_bytes(FORMATS[format].write(fitted, options))
    except NothingToExportError as error:
        _complain(str(file), f"not written: {error}")
    except OSError as error:
        _complain(str(file), f"cannot be written: {error.strerror or error}")
    else:
        return 0
    return BAD_INPUT


@app.command()
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
    labels: Labels = None,
    kind: Kinds = None,
    classifier: Classifier = None,
    criterion: Criterion = None,
    max_error: MaxError = None,
    tolerance: Tolerance = None,
    seed: Seed = None,
    constraint: Constraint = None,
    initial_guess: InitialGuess = None,
) -> None:
    """Recognise and fit many clouds; the answer of each goes into a file of its own.

    With --labels that of each segment goes into NAME/LABEL.json.

    Exit status: 0 when every input has its answer (whatever its status), 2 when one has not.
    """
    from .batch import SUFFIXES, CollisionError, plan, run

    options = _options(kind, classifier, criterion, max_error, tolerance, seed, constraint, initial_guess)
    try:
        targets = plan(inputs, out, format, labels)
    except CollisionError as error:
        _complain("batch", str(error))
        raise typer.Exit(BAD_INPUT) from None
    if not targets:
        _complain("batch", f"no {' '.join(SUFFIXES)} file was found")
        raise typer.Exit(BAD_INPUT)
    try:
        summary = run(targets, format, options, workers, labels)
    except OSError as error:
        _complain(str(error.filename or out), f"cannot be written: {error.strerror or error}")
        raise typer.Exit(BAD_INPUT) from None
    for problem in summary.problems:
        _complain(problem.name, problem.message)
    counts = ", ".join(f"{summary.statuses[status]} {status}" for status in EXIT)
    print(f"{summary.n_clouds} clouds: {counts}, {len(summary.problems)} with a problem; answers in {out}")
    raise typer.Exit(max((p.exit_status for p in summary.problems), key=BADNESS.index, default=0))


@app.command()
def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on.", show_default="127.0.0.1")] = None,
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="Port; 0 takes a free one.", show_default="8000")
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="Processes that read and fit.", show_default="one a core, up to 4"),
    ] = None,
    demo: Annotated[bool, typer.Option("--demo", help="Post an example cloud and print its answer.")] = False,
) -> None:
    """Serve the REST API; what is not given here comes from the environment or a file: `primfit settings`."""
    from ..service.server import ListenError, serve
    from ..service.settings import SettingsError

    try:
        serve(host, port, workers, demo)
    except SettingsError as error:
        for complaint in error.complaints:
            _complain("serve", complaint)
        raise typer.Exit(BAD_INPUT) from None
    except ListenError as error:
        _complain("serve", str(error))
        raise typer.Exit(BAD_INPUT) from None


@app.command()
def settings(
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Print what there is to set, as in docs/settings.md.")
    ] = False,
) -> None:
    """Check the settings of the service, and print those in force; keys are not shown.

    They come from PRIMFIT_<NAME> in the environment, else from the TOML file that PRIMFIT_CONFIG names.
    """
    from ..service.settings import SettingsError, load
    from ..service.settings_page import in_force, page

    if markdown:
        print(page(), end="")
        return
    try:
        print(in_force(load()), end="")
    except SettingsError as error:
        for complaint in error.complaints:
            _complain("settings", complaint)
        raise typer.Exit(BAD_INPUT) from None


@app.command()
def openapi() -> None:
    """Print the OpenAPI document of the service, from which clients are generated."""
    from ..service.api import create_app
    from ..service.openapi import as_text

    sys.stdout.buffer.write(as_text(create_app()))


@app.command()
def synth(
    recipe: Annotated[
        Literal["benchmark", "scanner", "scanner-hard", "scanner-large", "sensor", "foreign"],
        typer.Argument(help="The family of clouds.", metavar="RECIPE"),
    ],
    out: Annotated[Path, typer.Option(help="Folder for clouds, truth and picture.", file_okay=False)],
    n: Annotated[int, typer.Option("--n", min=1, help="Number of clouds.")] = 100,
    seed: Annotated[int, typer.Option(min=0, help="Another seed gives other clouds.")] = 0,
    picture: Annotated[bool, typer.Option(help="Draw the first thirty clouds as sample.png.")] = True,
) -> None:
    """Write labelled synthetic clouds, in the layout of the SHREC 2022 track.

    Cloud i depends on RECIPE, the seed and i only.
    """
    try:
        print(_installed("synth")(recipe, out, n, seed, picture))
    except (ImportError, OSError) as error:
        _complain("synth", str(error))
        raise typer.Exit(BAD_INPUT) from None


@app.command(
    context_settings={"allow_extra_args": True, "ignore_unknown_options": True}, add_help_option=False
)
def bench(context: typer.Context) -> None:
    """Measure primfit and what others make on the same clouds, and write the report."""
    try:
        command = _installed("bench")
    except ImportError as error:
        _complain("bench", str(error))
        raise typer.Exit(BAD_INPUT) from None
    raise typer.Exit(command(context.args))


def _installed(command: str) -> Callable[..., Any]:
    """The function of a command in a part that `app` does not import, found by its entry point."""
    from importlib.metadata import entry_points

    for entry in entry_points(group="primfit.commands", name=command):
        function: Callable[..., Any] = entry.load()
        return function
    raise ImportError("this installation is older than the command: pip install --editable . again")


def _options(
    kind: list[Kind] | None,
    classifier: str | None,
    criterion: str | None,
    max_error: float | None,
    tolerance: float | None,
    seed: int | None,
    constraint: list[str] | None,
    initial_guess: str | None,
) -> dict[str, Any]:
    """The options that were given, as the engine takes them, checked before the first file is read."""
    from ..engine.fit import InvalidOptionError, config_of
    from .constraint_flags import parse_constraints

    given: dict[str, Any] = {"classifier": classifier, "criterion": criterion, "max_error": max_error}
    given |= {"tolerance": tolerance, "seed": seed}
    options = {name: value for name, value in given.items() if value is not None}
    if kind:
        options["kinds"] = list(dict.fromkeys(map(str, kind)))
    try:
        if constraint:
            options["constraints"] = parse_constraints(constraint)
        if initial_guess is not None:
            options["initial_guess"] = _json(initial_guess)
        config_of(**options)
    except InvalidOptionError as error:
        option = error.field.partition(".")[0]
        _complain(f"--{FLAGS.get(option, option).replace('_', '-')}", str(error))
        raise typer.Exit(BAD_INPUT) from None
    return options


def _json(text: str) -> Any:
    """The value of a JSON text, or the text itself where it is none, for a complaint that shows it."""
    import orjson

    try:
        return orjson.loads(text)
    except orjson.JSONDecodeError:
        return text


def _complain(subject: str, message: str) -> None:
    print(f"primfit: {subject}: {message}", file=sys.stderr)


def _worse(one: int, other: int) -> int:
    return max(one, other, key=BADNESS.index)


def main() -> None:
    """Entry point of the `primfit` command."""
    app()


if __name__ == "__main__":
    main()
