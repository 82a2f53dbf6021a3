"""Rows of a run, chosen, joined and counted by DuckDB: what `primfit table` asks for.

Expressions are the SQL of whoever asks. Nothing is fetched from a network, and no extension is installed.
"""

import glob
import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson

from primfit.fitting.answer.restored import restored

from ..exports.many import Part
from .parts import part_files
from .rows import geo_of, said_of

NEEDED = "queries need an extra: pip install 'primfit[bulk]'"

READERS = {
    ".csv": "read_csv({file}, types = {{{on}: 'VARCHAR'}})",
    ".tsv": "read_csv({file}, types = {{{on}: 'VARCHAR'}})",
    ".parquet": "read_parquet({file})",
    ".json": "read_json({file})",
    ".ndjson": "read_json({file})",
}
"""How a file is read that is joined, by its suffix; texts keep their keys as they stand: 007 is not 7."""

FEW = "id, status, kind, n_points, radius, inlier_rms, message"
PLAIN = "* EXCLUDE (receipt, answer, bbox, geometry)"
ALL = "*"
"""Columns for people, for texts, and for Parquet."""

_ORDER = "filename, file_row_number"
_BATCH = 1_000
_GROUP = 10_000
"""Rows that are held at once: of answers, and of a Parquet file that is written."""


class BadQueryError(ValueError):
    """What was asked for does not hold; the message is DuckDB's, or as short."""


@dataclass(frozen=True)
class Query:
    """What is asked of the rows.

    Attributes
    ----------
    where : an SQL expression that holds for those that are chosen; None for all
    join, on : a file with more columns, and the column that both have; its rows are found by it, one each
    count : how many rows there are for each value of this column, or of several
    limit : rows at most
    """

    where: str | None = None
    join: Path | None = None
    on: str | None = None
    count: str | None = None
    limit: int | None = None


class Selection:
    """The rows that a query chooses out of the parts in a folder, or out of one Parquet file.

    Raises
    ------
    BadQueryError
        From the first method that is called, too, where a column is unknown.
    FileNotFoundError
        There are no parts, or no such file.
    ImportError
        DuckDB is missing.
    """

    def __init__(self, place: Path, query: Query) -> None:
        self.files = part_files(place) if place.is_dir() else [place]
        if not self.files or not self.files[0].exists():
            raise FileNotFoundError(f"{place} holds no part-*.parquet")
        self._duckdb = _duckdb()
        self._connection = self._duckdb.connect(config={"autoinstall_known_extensions": "false"})
        self._query = query
        # Geometries stay the bytes they are.
        self._run("SET enable_geoparquet_conversion = false")
        self._chosen = self._choose()

    def columns(self, columns: str | None, default: str) -> str:
        """The SQL of these columns, or of the counts where some are asked for."""
        query = self._query
        limit = "" if query.limit is None else f" LIMIT {query.limit}"
        if query.count is None:
            return f"SELECT {columns or self._there(default)} FROM ({self._chosen}){limit}"
        counts = f'SELECT {query.count}, count(*) AS "count" FROM ({self._chosen}) GROUP BY ALL'
        n_columns = len(self._described(counts))
        order = ", ".join([f"{n_columns} DESC", *map(str, range(1, n_columns))])
        return f"SELECT * FROM ({counts}) ORDER BY {order}{limit}"

    def rows(self, sql: str) -> tuple[list[str], list[tuple[Any, ...]]]:
        """The names of the columns, and all rows."""
        names = self._described(sql)
        return names, self._run(sql).fetchall()

    def write(self, sql: str, file: Path, format: str) -> None:
        """All rows as `csv` or `parquet`, all of the file or nothing; raises `OSError`."""
        part = file.with_name(f".{os.urandom(8).hex()}.part")
        try:
            self._run(f"COPY ({sql}) TO {_text(part)} ({self._how(sql, format)})")
            os.replace(part, file)
        finally:
            with suppress(OSError):
                part.unlink()

    def parts(self) -> Iterator[Part]:
        """The answers, for files about many of them."""
        found = self._run(self.columns("id, file, label, message, answer", ""))
        while batch := found.fetchmany(_BATCH):
            yield from (_part(*row) for row in batch)

    def _choose(self) -> str:
        """The SQL of the rows that are chosen, in the order of the parts."""
        files = ", ".join(_text(Path(glob.escape(str(file)))) for file in self.files)
        where = "" if self._query.where is None else f" WHERE ({self._query.where}\n)"
        if self._query.join is None:
            return f"SELECT * FROM read_parquet([{files}]){where}"
        answers = f"read_parquet([{files}], filename = true, file_row_number = true)"
        return f"SELECT * EXCLUDE ({_ORDER}) FROM ({self._joined(answers)}){where} ORDER BY {_ORDER}"

    def _joined(self, answers: str) -> str:
        """Each answer with what the file has about it; columns of names that are taken are `joined_...`."""
        file, on = self._query.join, self._query.on
        assert file and on
        if file.suffix.lower() not in READERS:
            raise BadQueryError(f"{file} is none of {', '.join(READERS)}")
        other = READERS[file.suffix.lower()].format(file=_text(Path(glob.escape(str(file)))), on=_text(on))
        other = f"SELECT * FROM {other}"
        taken = {name.casefold() for name in self._described(f"SELECT * FROM {answers}")}
        names = [name for name in self._described(other) if name.casefold() != on.casefold()]
        more = [
            f"other.{_name(name)} AS {_name(f'joined_{name}' if name.casefold() in taken else name)}"
            for name in names
        ]
        key = f"CAST({_name(on)} AS VARCHAR)"
        twice = (
            f"SELECT {key} FROM ({other}) WHERE {key} IS NOT NULL GROUP BY 1 HAVING count(*) > 1 ORDER BY 1"
        )
        if found := self._run(f"{twice} LIMIT 1").fetchone():
            raise BadQueryError(f"{file} has the {on} {found[0]!r} more than once")
        match = f"CAST(answers.{_name(on)} AS VARCHAR) = CAST(other.{_name(on)} AS VARCHAR)"
        columns = ", ".join(["answers.*", *more])
        return f"SELECT {columns} FROM {answers} AS answers LEFT JOIN ({other}) AS other ON {match}"

    def _there(self, columns: str) -> str:
        """Default columns without those that the file was written without."""
        names = self._described(self._chosen)
        if columns == FEW:
            return ", ".join(name for name in FEW.split(", ") if name in names) or ALL
        left_out = [name for name in ("receipt", "answer", "bbox", "geometry") if name in names]
        return f"* EXCLUDE ({', '.join(left_out)})" if columns == PLAIN and left_out else ALL

    def _how(self, sql: str, format: str) -> str:
        """The options of a file in this format."""
        if format == "csv":
            return "FORMAT csv, HEADER"
        said = {"primfit": said_of({}).decode()}
        if {"geometry", "bbox"} <= set(self._described(sql)):
            said["geo"] = geo_of(None).decode()
        metadata = ", ".join(f"{name}: {_text(text)}" for name, text in said.items())
        return f"FORMAT parquet, COMPRESSION zstd, ROW_GROUP_SIZE {_GROUP}, KV_METADATA {{{metadata}}}"

    def _described(self, sql: str) -> list[str]:
        """The names of the columns."""
        return [row[0] for row in self._run(f"DESCRIBE {sql}").fetchall()]

    def _run(self, sql: str) -> Any:
        try:
            if len(self._duckdb.extract_statements(sql)) != 1:
                raise BadQueryError("one expression is needed, not several statements")
            return self._connection.execute(sql)
        except self._duckdb.IOException as error:
            raise OSError(_said(error)) from None
        except self._duckdb.Error as error:
            raise BadQueryError(_said(error)) from None


def _part(id: str, file: str, label: str | None, message: str, answer: str | None) -> Part:
    found = None if answer is None else restored(orjson.loads(answer))
    return Part({"id": id, "file": file, "label": label}, id, found, "" if found else message)


def _duckdb() -> Any:
    try:
        import duckdb
    except ImportError as error:
        raise ImportError(NEEDED) from error
    return duckdb


def _said(error: Exception) -> str:
    """DuckDB's words in one line, without the query."""
    return " ".join(str(error).partition("\n\nLINE ")[0].split())


def _text(value: str | Path) -> str:
    """A text in SQL."""
    return "'" + str(value).replace("'", "''") + "'"


def _name(name: str) -> str:
    """The name of a column in SQL."""
    return '"' + name.replace('"', '""') + '"'


def answers_of(selection: Selection) -> Sequence[Part]:
    """All answers of a selection; raises `BadQueryError` where the column `answer` holds none."""
    try:
        return list(selection.parts())
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, BadQueryError):
            raise
        raise BadQueryError(f"the column answer holds none: {error}") from None
