"""A cloud as read: points, normals where the file has them, and where both were found."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.equality import ByValue
from primfit.fitting.names import Unit

from .columns import Columns
from .errors import SHOWN, FieldError, InvalidPointsError, UnreadableFileError
from .formats import UNIT_OF

Array = NDArray[np.float64]
UnitSource = Literal["option", "header", "format"]

_LABEL_LIMIT = 200
PER_POINT = ("points", "normals", "weights", "standard_deviations")


@dataclass(frozen=True, eq=False)
class Cloud(ByValue):
    """What a file holds, or what was given in its place.

    Attributes
    ----------
    points : (N, 3) float64; as read, some may be NaN or infinite, until `app.readers.missing` drops these
    columns : names in the file of what was read
    normals : (N, 3) unit normals, or None
    format : one of `FORMATS`, or `array`
    options : that stood beside the points, as JSON may hold them; not checked yet
    weights, standard_deviations : (N,) that stood there, too; checked to be numbers, no more
    labels : (N,) integers or strings that tell the segments of a scan apart
    label_column : the name of their column in the file
    unit, unit_from : of the coordinates, where it is known, and what says so
    dropped : how many points are missing, by why
    warnings : what the caller should know of the file, a sentence each

    Examples
    --------
    >>> import numpy as np, primfit
    >>> cloud = primfit.Cloud(np.eye(3), ("x", "y", "z"), None, "array", unit="mm")
    >>> cloud.points.shape, cloud.unit
    ((3, 3), 'mm')
    """

    points: Array
    columns: tuple[str, ...]
    normals: Array | None
    format: str
    options: Mapping[str, Any] = field(default_factory=dict)
    weights: Array | None = None
    standard_deviations: Array | None = None
    labels: NDArray[Any] | None = None
    label_column: str | None = None
    unit: Unit | None = None
    unit_from: UnitSource | None = None
    dropped: Mapping[str, int] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


def string_labels(labels: Sequence[str]) -> NDArray[Any]:
    """Labels (N,) as an array of objects, in which a long one does not widen the others."""
    if max(map(len, labels), default=0) > _LABEL_LIMIT:
        raise UnreadableFileError("labels", f"a label is over {_LABEL_LIMIT} characters long")
    return np.array(labels, object)


def build_cloud(table: Array, columns: Columns, format: str, labels: NDArray[Any] | None = None) -> Cloud:
    """Cut points and normals out of a table (N, C).

    `labels` (N,) are those of the column `columns.label`, which may be no numbers.
    """
    # The first three columns, which most are, are a view of the table: to pick them by number is slower.
    chosen = table[:, :3] if columns.points == (0, 1, 2) else table[:, columns.points]
    points = np.ascontiguousarray(chosen, dtype=np.float64)
    normals = unit_normals(table[:, columns.normals], points) if columns.normals else None
    names = columns.names if normals is not None else columns.names[:3]
    cloud = Cloud(points, names, normals, format, labels=labels, label_column=columns.label_name)
    unit: Unit | None = columns.unit or UNIT_OF.get(format)
    if unit is None and not columns.warnings:
        return cloud
    source: UnitSource | None = "header" if columns.unit else "format" if unit else None
    return replace(cloud, unit=unit, unit_from=source, warnings=columns.warnings)


def build_from(columns: Columns, column: Callable[[int], NDArray[Any]], format: str, first: int = 0) -> Cloud:
    """The cloud of a table of which `column(i)` gives the values (N,) of the i-th column.

    `first` is the number of its first row, where others stand before it in the file.
    """
    names = zip(columns.used, columns.names, strict=True)
    table = np.column_stack([_one_a_point(column(i), name) for i, name in names])
    labels = None if columns.label is None else as_labels(column(columns.label), table[:, :3], first)
    return build_cloud(table, columns.packed(), format, labels)


def _one_a_point(values: NDArray[Any], field: str) -> Array:
    if values.ndim != 1:
        raise InvalidPointsError(field, "the column holds several numbers a point", "array")
    return as_float(values, field)


def as_float(values: NDArray[Any], field: str) -> Array:
    """Numbers as float64; what is no number is refused under the name of its field."""
    check_numbers(values.dtype, field)
    with np.errstate(over="ignore"):
        return values.astype(np.float64)


def check_numbers(dtype: np.dtype[Any], field: str) -> None:
    """Raise `InvalidPointsError` where an array holds no numbers."""
    if dtype.kind not in "fiu":
        raise InvalidPointsError(field, "the array must hold floats or integers", f"dtype kind {dtype.kind}")


def as_labels(values: NDArray[Any], points: Array, first: int = 0) -> NDArray[np.int64]:
    """Labels (N,) as int64; floats count where they hold whole numbers.

    A point that is missing needs none: its label is 0. `first` is the number of the first point.
    """
    if values.dtype.kind not in "fiu" or values.ndim != 1:
        raise UnreadableFileError("labels", "labels must be integers, one a point")
    with np.errstate(invalid="ignore"):
        whole = (values == np.rint(values)) & (values >= -(2.0**63)) & (values < 2.0**63)
    if not whole.all():
        bad = np.flatnonzero(~whole & np.isfinite(points).all(axis=1))
        if len(bad):
            message = "labels must be integers of at most 64 bits"
            raise UnreadableFileError(f"labels[{first + bad[0]}]", message, "number")
        values = np.where(whole, values, 0)
    return values.astype(np.int64)


def selected(cloud: Cloud, rows: NDArray[Any], **others: Any) -> Cloud:
    """The cloud of these rows (M,), and without labels unless others are given."""
    chosen: dict[str, Any] = {name: values[rows] for name, values in per_point(cloud).items()}
    return replace(cloud, **chosen, **{"labels": None, **others})


def per_point(cloud: Cloud) -> dict[str, Array]:
    """What a cloud holds for each of its points, but for the labels, by name."""
    given = {name: getattr(cloud, name) for name in PER_POINT}
    return {name: values for name, values in given.items() if values is not None}


def check_finite(points: Array, field: str = "points") -> None:
    """Raise `InvalidPointsError` naming the first coordinates that are NaN or infinite."""
    bad = ~np.isfinite(points)
    if not bad.any():
        return
    rows = np.flatnonzero(bad.any(axis=1))[:SHOWN]
    errors = [
        FieldError(
            f"{field}[{rows[i]}][{j}]",
            "not a finite number; every coordinate must be one",
            "NaN" if np.isnan(points[rows[i], j]) else "infinity",
        )
        for i, j in np.argwhere(bad[rows])
    ]
    raise InvalidPointsError(
        errors[0].field,
        f"{np.count_nonzero(bad)} coordinates are NaN or infinite; every one must be finite",
        errors=errors,
    )


def unit_normals(normals: Array, points: Array | None = None) -> Array | None:
    """Normals scaled to length 1, or None where one of them has no direction: then none is trusted.

    Those of `points` that are missing do not count.
    """
    with np.errstate(all="ignore"):
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        usable = np.isfinite(lengths) & (lengths > 0.0)
        if not usable.all():
            there = True if points is None else np.isfinite(points).all(axis=1, keepdims=True)
            if (~usable & there).any():
                return None
        return np.ascontiguousarray(normals / lengths, dtype=np.float64)
