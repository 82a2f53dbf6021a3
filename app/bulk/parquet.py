"""Parquet files as inputs: their rows are segments with their points, single points, or references to clouds.

It is read by pyarrow, which the extra `bulk` brings, a few rows at a time: row groups may be large.
"""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..engine.cut import Label
from ..readers import Cloud, Pick, UnreadableFileError
from ..readers.cloud import as_labels, build_cloud, string_labels
from ..readers.columns import Columns, as_columns, find_columns
from . import places
from .arrow import arrow
from .refs import Ref, segment_id
from .repeated import repeated

_ROWS = 64
"""Rows that are segments and are read at once; one of them may hold as many points as a task."""

_POINTS = 500_000

_ID, _PATH, _LABEL, _TRIPLES = "id", "path", "label", "points"


def is_parquet(place: str) -> bool:
    """Whether this is the name of a Parquet file."""
    return place.lower().endswith((".parquet", ".pq"))


def references(file: str, place: str, columns: object) -> Iterator[Ref] | None:
    """The segments of a file of which each row is one or refers to one; None where a row is a point.

    `place` is where any machine finds it. Raises `UnreadableFileError` where it is none of these.
    """
    table = _opened(place)
    schema = table.schema_arrow
    if _is(schema, _PATH, "is_string", "is_large_string"):
        _check_ids(table, _ID if _ID in schema.names else _PATH, schema)
        return _referred(file, place, table, schema.names)
    if _is_list(schema, _TRIPLES) or _lists(schema):
        if _ID in schema.names:
            _check_ids(table, _ID, schema)
        return _segments(file, place, table, schema)
    _columns(schema, Pick(None, as_columns(columns)))
    return None


def n_rows(place: str) -> int:
    """How many rows a file has."""
    return int(_opened(place).metadata.num_rows)


def point_pieces(place: str, pick: Pick, n_points: int = _POINTS) -> Iterator[Cloud]:
    """The cloud of a file of which each row is a point, in pieces."""
    yield from _point_rows(place, pick, n_points)


def segment(place: str, start: int, stop: int, columns: object) -> Cloud:
    """The cloud of these rows: of one that is a segment, or of several that are its points."""
    schema = _opened(place).schema_arrow
    if _is_list(schema, _TRIPLES) or _lists(schema):
        return _cloud_of(_row(place, start), schema, columns)
    pieces = list(_point_rows(place, Pick(None, as_columns(columns)), _POINTS))
    points = np.concatenate([piece.points for piece in pieces])[start:stop]
    normals = [piece.normals for piece in pieces if piece.normals is not None]
    trusted = np.concatenate(normals)[start:stop] if len(normals) == len(pieces) else None
    return Cloud(points, pieces[0].columns[: 3 if trusted is None else 6], trusted, "array")


def _referred(file: str, place: str, table: Any, names: Sequence[str]) -> Iterator[Ref]:
    """The clouds that the rows refer to, by paths from the folder of the file on, or by URLs."""
    wanted = [name for name in (_ID, _PATH, _LABEL) if name in names]
    folder = place.rpartition("/")[0] or "/"
    for batch in table.iter_batches(batch_size=10_000, columns=wanted):
        for row in batch.to_pylist():
            path = row[_PATH]
            if not path:
                raise UnreadableFileError("path", "a row of references has no path")
            target = path if places.is_remote(path) or path.startswith("/") else places.joined(folder, path)
            id, n_bytes, problem = segment_id(file, row.get(_ID, path)), None, None
            try:
                # It is not worth a request to a server to know the bytes of a cloud.
                n_bytes = None if places.is_remote(target) else places.size(target)
            except OSError as error:
                problem = ("file", error.strerror or str(error), False)
            n_points = places.about_points(n_bytes)
            yield Ref(id, path, row.get(_LABEL), n_points, target, problem=problem)


def _segments(file: str, place: str, table: Any, schema: Any) -> Iterator[Ref]:
    """The rows that hold their points; without a column of ids they are numbered from 0."""
    import pyarrow.compute

    measured = _TRIPLES if _TRIPLES in schema.names else _lists(schema)[0]
    wanted = [name for name in (_ID, measured) if name in schema.names]
    number = 0
    for batch in table.iter_batches(batch_size=_ROWS, columns=wanted):
        lengths = pyarrow.compute.list_value_length(batch.column(measured)).to_pylist()
        ids = batch.column(_ID).to_pylist() if _ID in wanted else range(number, number + len(lengths))
        for id, length in zip(ids, lengths, strict=True):
            label: Label = id if isinstance(id, int) else str(id)
            yield Ref(segment_id(file, label), file, label, length or 0, place, number, number + 1)
            number += 1


def _check_ids(table: Any, name: str, schema: Any) -> None:
    """Raise where an id stands twice, or a row has none."""
    if not _is(schema, name, "is_string", "is_large_string", "is_integer"):
        raise UnreadableFileError(name, f"the column {name} must hold strings or whole numbers")

    def ids() -> Iterator[str]:
        for batch in table.iter_batches(batch_size=100_000, columns=[name]):
            if batch.column(0).null_count:
                raise UnreadableFileError(name, f"a row has no {name}")
            yield from map(str, batch.column(0).to_pylist())

    if repeated(ids) is not None:
        raise UnreadableFileError(name, f"the column {name} holds a value twice")


def _opened(place: str) -> Any:
    """The Parquet file, whose footer is read once."""
    try:
        return _kept(place)
    except ImportError:
        raise
    except ValueError as error:  # pyarrow.ArrowInvalid
        raise UnreadableFileError("file", "the file is no Parquet file, or is damaged") from error


@lru_cache(maxsize=4)
def _kept(place: str) -> Any:
    arrow()
    from pyarrow.parquet import ParquetFile

    file = places.opened(place) if places.is_remote(place) else place
    return ParquetFile(file, pre_buffer=False, buffer_size=2**20)


class _Walk:
    """The rows of a row group, a few of which are held; they are asked for in about their order."""

    def __init__(self, place: str, group: int, first: int) -> None:
        self.place, self.group, self.first = place, group, first
        table = _opened(place)
        schema = table.schema_arrow
        wanted = [_TRIPLES] if _TRIPLES in schema.names else _lists(schema)
        self._batches = table.iter_batches(batch_size=_ROWS, row_groups=[group], columns=wanted)
        self._begin, self._batch = first, next(self._batches)

    def row(self, number: int) -> dict[str, Any] | None:
        """A row by its number in the file; None where it has been passed."""
        if number < self._begin:
            return None
        while number >= self._begin + self._batch.num_rows:
            self._begin += self._batch.num_rows
            self._batch = next(self._batches)
        names = self._batch.schema.names
        return {name: self._batch.column(name)[number - self._begin] for name in names}


_walk: _Walk | None = None


def _row(place: str, number: int) -> dict[str, Any]:
    """What stands in a row of the file."""
    global _walk
    group, first = _group_of(place, number)
    if _walk is None or (_walk.place, _walk.group) != (place, group):
        _walk = _Walk(place, group, first)
    found = _walk.row(number)
    if found is None:
        _walk = _Walk(place, group, first)
        found = _walk.row(number)
    assert found is not None
    return found


def _group_of(place: str, number: int) -> tuple[int, int]:
    """The row group of a row, and the number of its first row."""
    metadata, first = _opened(place).metadata, 0
    for group in range(metadata.num_row_groups):
        n_rows = metadata.row_group(group).num_rows
        if number < first + n_rows:
            return group, first
        first += n_rows
    raise UnreadableFileError("file", f"the file has {first} rows; row {number} was asked for")


def _cloud_of(row: dict[str, Any], schema: Any, columns: object) -> Cloud:
    if any(not value.is_valid for value in row.values()):
        raise UnreadableFileError("points", "the row has no points")
    if _TRIPLES in row:
        return Cloud(_triples(row[_TRIPLES].values), ("x", "y", "z"), None, "array")
    lists = _lists(schema)
    found = find_columns(lists, Pick(None, as_columns(columns)))
    values = [_floats(row[lists[i]].values) for i in found.used]
    if len({len(each) for each in values}) > 1:
        raise UnreadableFileError("points", "the lists of coordinates are not equally long")
    return build_cloud(np.column_stack(values), found.packed(), "array")


def _triples(points: Any) -> NDArray[np.float64]:
    """Points (N, 3) of a list of lists of three numbers each."""
    import pyarrow.types as types

    fixed = types.is_fixed_size_list(points.type) and points.type.list_size == 3
    lengths = set() if fixed else set(points.value_lengths().to_pylist())
    if points.null_count or not lengths <= {3}:
        raise UnreadableFileError("points", "a point is not a list of three numbers")
    return _floats(points.flatten()).reshape(-1, 3)


def _floats(values: Any) -> NDArray[np.float64]:
    """Numbers (N,); where one is missing it is NaN."""
    return np.array(values.cast("float64").to_numpy(zero_copy_only=False), np.float64)


def _point_rows(place: str, pick: Pick, n_points: int) -> Iterator[Cloud]:
    table = _opened(place)
    columns, names = _columns(table.schema_arrow, pick)
    wanted, first = [names[i] for i in columns.wanted], 0
    for batch in table.iter_batches(batch_size=n_points, columns=list(dict.fromkeys(wanted))):
        points = np.column_stack([_floats(batch.column(names[i])) for i in columns.used])
        labels = None if columns.label is None else _labels(batch.column(names[columns.label]), points, first)
        yield build_cloud(points, columns.packed(), "array", labels)
        first += batch.num_rows


def _labels(values: Any, points: NDArray[np.float64], first: int) -> NDArray[Any]:
    import pyarrow.types as types

    if values.null_count:
        raise UnreadableFileError("labels", "a point has no label")
    if types.is_dictionary(values.type):
        values = values.dictionary_decode()
    if types.is_string(values.type) or types.is_large_string(values.type):
        return string_labels(values.to_pylist())
    return as_labels(values.to_numpy(zero_copy_only=False), points[:, :3], first)


def _columns(schema: Any, pick: Pick) -> tuple[Columns, list[str]]:
    """The columns of a table of points, and the names of all that hold one value a row."""
    import pyarrow.types as types

    names = [field.name for field in schema if not types.is_nested(field.type)]
    return find_columns(names, pick), names


def _is(schema: Any, name: str, *kinds: str) -> bool:
    import pyarrow.types as types

    return name in schema.names and any(getattr(types, kind)(schema.field(name).type) for kind in kinds)


def _is_list(schema: Any, name: str) -> bool:
    return _is(schema, name, "is_list", "is_large_list")


def _lists(schema: Any) -> list[str]:
    """The columns that hold a list of numbers a row."""
    import pyarrow.types as types

    return [
        field.name
        for field in schema
        if (types.is_list(field.type) or types.is_large_list(field.type))
        and not types.is_nested(field.type.value_type)
    ]
