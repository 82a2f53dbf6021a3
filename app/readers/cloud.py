"""A cloud as read: points, normals where the file has them, and where both were found."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import SHOWN, FieldError, InvalidPointsError, UnreadableFileError, describe

Array = NDArray[np.float64]

_ALIASES = {
    "x": ("x", "px", "pos_x", "pointx", "point_x", "coord_x", "points:0", "points_0"),
    "y": ("y", "py", "pos_y", "pointy", "point_y", "coord_y", "points:1", "points_1"),
    "z": ("z", "pz", "pos_z", "pointz", "point_z", "coord_z", "points:2", "points_2"),
    "nx": ("nx", "normal_x", "normalx", "normals:0", "normals_0"),
    "ny": ("ny", "normal_y", "normaly", "normals:1", "normals_1"),
    "nz": ("nz", "normal_z", "normalz", "normals:2", "normals_2"),
}
AUTO_LABELS = "auto"
_LABELS = ("label", "labels", "segment", "segment_id", "segments", "instance", "instance_id", "instances")
_LABEL_LIMIT = 200
_XYZ, _NORMAL = ("x", "y", "z"), ("nx", "ny", "nz")
_NAME_OF = {alias: name for name, aliases in _ALIASES.items() for alias in aliases}


@dataclass(frozen=True)
class Cloud:
    """Points (N, 3) float64, the columns they were read from, unit normals (N, 3) or None, and the format.

    `options`, and `weights` or `standard_deviations` (N,), stood beside the points: JSON may hold them. The
    options are not checked yet, and of the others only that they are numbers. `labels` (N,), integers or
    strings, tell the segments of a scan apart; `label_column` is the name of their column in the file.
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


@dataclass(frozen=True)
class Columns:
    """Positions of x, y, z and, where present, nx, ny, nz in a table, and their names in the file.

    `label` and `label_name` are those of the column of labels, where it is asked for and there.
    """

    names: tuple[str, ...]
    points: tuple[int, ...]
    normals: tuple[int, ...] = ()
    label: int | None = None
    label_name: str | None = None

    @property
    def used(self) -> tuple[int, ...]:
        return self.points + self.normals

    @property
    def wanted(self) -> tuple[int, ...]:
        """Those used, and that of the labels."""
        return self.used if self.label is None else (*self.used, self.label)

    def packed(self) -> "Columns":
        """The same columns in a table that holds only the used ones, in their order."""
        return replace(self, points=(0, 1, 2), normals=(3, 4, 5) if self.normals else ())


def canonical(name: str) -> str | None:
    """Which of x, y, z, nx, ny, nz a column name means: `X [mm]`, `//X` and `point_x` all mean x."""
    return _NAME_OF.get(_bare(name))


def _bare(name: str) -> str:
    bare = re.sub(r"[\[(].*$", "", name.strip().strip("\"'").lstrip("/#").strip()).strip().lower()
    return bare.replace(" ", "_")


def find_label(names: Sequence[str], wanted: str | None) -> int | None:
    """The position of the column of labels: the wanted one by its name, or one of the usual names.

    Raises `UnreadableFileError` where no column has the wanted name, or several may be meant.
    """
    if wanted is None:
        return None
    found = _usual_labels(names) if wanted == AUTO_LABELS else _named(names, wanted)
    if len(found) > 1:
        raise UnreadableFileError("labels", f"{len(found)} columns may be the labels; name one of them")
    return found[0] if found else None


def _usual_labels(names: Sequence[str]) -> list[int]:
    return [i for i, name in enumerate(names) if _bare(name) in _LABELS]


def _named(names: Sequence[str], wanted: str) -> list[int]:
    """Columns of this very name, or else of one that means the same."""
    found = [i for i, name in enumerate(names) if name.strip() == wanted]
    found = found or [i for i, name in enumerate(names) if _bare(name) == _bare(wanted)]
    if not found:
        raise UnreadableFileError("labels", f"no column of this name among {len(names)}", describe(wanted))
    return found


def string_labels(labels: Sequence[str]) -> NDArray[Any]:
    """Labels (N,) as an array of objects, in which a long one does not widen the others."""
    if max(map(len, labels), default=0) > _LABEL_LIMIT:
        raise UnreadableFileError("labels", f"a label is over {_LABEL_LIMIT} characters long")
    return np.array(labels, object)


def find_columns(names: Sequence[str], labels: str | None = None) -> Columns:
    """Pick the coordinate and normal columns of a table by name, and the labels as `find_label` does."""
    places = _places(names)
    missing = [name for name in _XYZ if name not in places]
    if missing:
        raise UnreadableFileError(
            "header",
            f"no column named {', '.join(missing)} among {len(names)}; name the coordinates x, y, z",
            no_cloud=True,
        )
    wanted = _XYZ + _NORMAL if places.keys() >= set(_NORMAL) else _XYZ
    indices = [places[name] for name in wanted]
    used = tuple(names[i].strip()[:40] for i in indices)
    label = find_label(names, labels)
    label_name = None if label is None else names[label].strip()[:40]
    return Columns(used, tuple(indices[:3]), tuple(indices[3:]), label, label_name)


def _places(names: Sequence[str]) -> dict[str, int]:
    """Where x, y, z, nx, ny and nz stand, those that are there; each once at most."""
    places: dict[str, list[int]] = {}
    for index, name in enumerate(names):
        meaning = canonical(name)
        if meaning is not None:
            places.setdefault(meaning, []).append(index)
    for meaning, found in places.items():
        if len(found) > 1:
            raise UnreadableFileError("header", f"{len(found)} columns are named {meaning}; keep one of them")
    return {meaning: index for meaning, (index,) in places.items()}


def count_columns(width: int) -> Columns:
    """Columns of a table without names: the first three are x, y, z, the rest is not used."""
    if width < 3:
        message = f"rows hold {width} values; a point needs x, y and z"
        raise UnreadableFileError("file", message, no_cloud=True)
    return Columns(("x", "y", "z"), (0, 1, 2))


def build_cloud(table: Array, columns: Columns, format: str, labels: NDArray[Any] | None = None) -> Cloud:
    """Cut points and normals out of a table (N, C) and check that every coordinate is finite.

    `labels` (N,) are those of the column `columns.label`, which may be no numbers.
    """
    # The first three columns, which most are, are a view of the table: to pick them by number is slower.
    chosen = table[:, :3] if columns.points == (0, 1, 2) else table[:, columns.points]
    points = np.ascontiguousarray(chosen, dtype=np.float64)
    check_finite(points)
    normals = unit_normals(table[:, columns.normals]) if columns.normals else None
    names = columns.names if normals is not None else columns.names[:3]
    return Cloud(points, names, normals, format, labels=labels, label_column=columns.label_name)


def build_from(columns: Columns, column: Callable[[int], NDArray[Any]], format: str) -> Cloud:
    """The cloud of a table of which `column(i)` gives the values (N,) of the i-th column."""
    names = zip(columns.used, columns.names, strict=True)
    table = np.column_stack([_one_a_point(column(i), name) for i, name in names])
    labels = None if columns.label is None else as_labels(column(columns.label))
    return build_cloud(table, columns.packed(), format, labels)


def _one_a_point(values: NDArray[Any], field: str) -> Array:
    if values.ndim != 1:
        raise InvalidPointsError(field, "the column holds several numbers a point", "array")
    return as_float(values, field)


def as_float(values: NDArray[Any], field: str) -> Array:
    """Numbers as float64; what is no number is refused under the name of its field."""
    if values.dtype.kind not in "fiu":
        kind = f"dtype kind {values.dtype.kind}"
        raise InvalidPointsError(field, "the array must hold floats or integers", kind)
    with np.errstate(over="ignore"):
        return values.astype(np.float64)


def as_labels(values: NDArray[Any]) -> NDArray[np.int64]:
    """Labels (N,) as int64; floats count where they hold whole numbers."""
    if values.dtype.kind not in "fiu" or values.ndim != 1:
        raise UnreadableFileError("labels", "labels must be integers, one a point")
    with np.errstate(invalid="ignore"):
        whole = (values == np.rint(values)) & (values >= -(2.0**63)) & (values < 2.0**63)
    if not whole.all():
        bad = int(np.argmin(whole))
        raise UnreadableFileError(f"labels[{bad}]", "labels must be integers of at most 64 bits", "number")
    return values.astype(np.int64)


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


def unit_normals(normals: Array) -> Array | None:
    """Normals scaled to length 1, or None where one of them has no direction: then none is trusted."""
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    if not (np.isfinite(lengths).all() and (lengths > 0.0).all()):
        return None
    return np.ascontiguousarray(normals / lengths, dtype=np.float64)
