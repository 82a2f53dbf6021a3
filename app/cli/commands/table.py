"""`primfit table`: rows of a run, chosen, joined, counted, and written in another format."""

import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from primfit.fitting.names import Unit

from ..status import complain, refused

if TYPE_CHECKING:
    from ...bulk.selection import Selection

GATHERED = ("glb", "step", "report")
SHOWN = 40
"""Rows of a text, unless more are asked for."""


def table(
    context: typer.Context,
    place: Annotated[
        Path,
        typer.Argument(metavar="OUT", help="Folder of 'primfit batch --format parquet', or a Parquet file."),
    ],
    where: Annotated[
        str | None,
        typer.Option(metavar="SQL", help="Choose rows: \"kind = 'cylinder' AND radius < 0.1\"."),
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(metavar="SQL", help="Columns, or expressions of them: 'id, 2 * radius AS diameter'."),
    ] = None,
    count: Annotated[
        str | None,
        typer.Option(metavar="COLUMN", help="How many rows there are for each value of it, or of several."),
    ] = None,
    join: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="CSV, TSV, Parquet or JSON with more columns.", dir_okay=False),
    ] = None,
    on: Annotated[
        str | None,
        typer.Option(metavar="COLUMN", help="By which rows of FILE are found.", show_default="id"),
    ] = None,
    format: Annotated[
        Literal["text", "csv", "parquet", "glb", "step", "report"],
        typer.Option(help="Text for people, tables, or all trimmed primitives in one file or page."),
    ] = "text",
    out: Annotated[
        Path | None, typer.Option(help="Write to it; text and csv are printed without it.", dir_okay=False)
    ] = None,
    limit: Annotated[
        int | None, typer.Option(min=0, help=f"Rows at most; a text has {SHOWN} unless more are asked for.")
    ] = None,
    unit: Annotated[
        Unit | None,
        typer.Option(help="Of lengths in glb, step and report, where the fits did not know it."),
    ] = None,
) -> None:
    """Choose rows of a run, by SQL of DuckDB, and show, count, join or export them.

    Exit status: 0 done, 2 a bad expression, or nothing to write.
    """
    from ...bulk.selection import BadQueryError, Query, Selection

    _check(context.params)
    shown = SHOWN + 1 if format == "text" and limit is None else limit
    try:
        _note(place)
        selection = Selection(place, Query(where, join, on or "id", count, shown))
        _check_overwriting(selection, join, out)
        if format in GATHERED:
            assert out
            _gather(selection, format, out, unit)
        else:
            _tabulate(selection, columns, format, out, limit is not None)
    except BadQueryError as error:
        raise refused("table", str(error)) from None
    except ImportError as error:
        raise refused("table", str(error)) from None
    except OSError as error:
        raise refused(str(error.filename or place), str(error.strerror or error)) from None


def _check(given: Mapping[str, Any]) -> None:
    """End with a complaint about options that do not go together."""
    format, gathered = given["format"], given["format"] in GATHERED
    if given["out"] is None and format not in ("text", "csv"):
        raise refused("--out", f"a file is needed for {format}")
    if gathered and (given["columns"] or given["count"]):
        raise refused("--format", f"{format} has no columns: leave out --columns and --count")
    if given["columns"] and given["count"]:
        raise refused("--count", "it names the columns: leave out --columns")
    if given["on"] and not given["join"]:
        raise refused("--on", "there is no --join FILE")
    if given["unit"] and not gathered:
        raise refused("--unit", f"it is for {', '.join(GATHERED)}")


def _check_overwriting(selection: "Selection", join: Path | None, out: Path | None) -> None:
    if out is None:
        return
    read = [*selection.files, *([join] if join else [])]
    if out.resolve() in {file.resolve() for file in read}:
        raise refused("--out", f"it would overwrite the input {out}")


def _note(place: Path) -> None:
    """Say that a run is not finished."""
    from ...bulk.parts import OtherRunError, progress_of

    try:
        found = progress_of(place)
    except OtherRunError as error:
        raise refused("table", str(error)) from None
    if found and (found[0] < found[1] or not found[1]):
        complain(
            str(place), f"the run is not finished: {found[0]} of {found[1] or 'an unknown number of'} tasks"
        )


def _tabulate(
    selection: "Selection", columns: str | None, format: str, out: Path | None, limited: bool
) -> None:
    from ...bulk.selection import ALL, FEW, PLAIN
    from ..tabular import as_text

    sql = selection.columns(columns, {"text": FEW, "csv": PLAIN, "parquet": ALL}[format])
    if format == "text":
        _tell(as_text(*selection.rows(sql), None if limited else SHOWN), out)
    elif out is not None:
        selection.write(sql, out, format)
    else:
        with TemporaryDirectory() as folder:
            file = Path(folder) / "table.csv"
            selection.write(sql, file, format)
            sys.stdout.flush()
            with file.open("rb") as lines:
                shutil.copyfileobj(lines, sys.stdout.buffer)


def _tell(text: str, out: Path | None) -> None:
    if out is None:
        print(text, end="")
    else:
        out.write_text(text, encoding="utf-8")


def _gather(selection: "Selection", format: str, out: Path, unit: Unit | None) -> None:
    """All answers of the selection in one file."""
    from primfit.fitting.errors import InvalidOptionError

    from ...bulk.selection import answers_of
    from ...exports import ExportOptions, NothingToExportError
    from ...exports.many import write_many

    try:
        content = write_many(answers_of(selection), format, ExportOptions(unit))
    except (NothingToExportError, InvalidOptionError) as error:
        raise refused(str(out), f"not written: {error}") from None
    out.write_bytes(content)
