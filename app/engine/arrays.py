"""Clouds as other libraries hold them: told apart by what they have, so that none is imported."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError

from ..readers.cloud import Array, Cloud, unit_normals
from ..readers.columns import FOUND, XYZ, Pick, find_columns
from ..readers.errors import UnreadableFileError
from ..readers.npy import is_transposed, read_table

WANTED = "give an array (N, 3), a table with columns x, y, z, or an object that holds points or vertices"

FORMAT = "array"
"""Of a cloud that came from no file."""

_NUMBERS = "biufO"
"""Kinds of arrays that may hold real numbers: no complex ones, texts, dates or records."""


def as_cloud(given: Any, pick: Pick = FOUND) -> Cloud:
    """The points (N, 3) of an object, the unit normals (N, 3) that it holds, if it does, and any warnings.

    Parameters
    ----------
    given : an array (N, 3), or what NumPy makes one of: of a wider one (N, C) the first three columns count,
        or those behind an index, and an organized one (H, W, 3) is taken row by row; a tensor of torch, from
        any device; a table (pandas) or an array of records with columns x, y, z and perhaps nx, ny, nz, or
        other names that files use for them; a point cloud of Open3D, with its normals, or of trimesh; or a
        mesh of theirs, of which the vertices count: its normals would be those of its faces
    pick : which columns of an array or a table are asked for

    Raises
    ------
    InvalidPointCloudError
        It is none of these, or holds no numbers.
    """
    if names := _column_names(given):
        return _columns(given, names, pick)
    points, normals = _held(given)
    if normals is not None:
        return _cloud(as_floats(points, "points"), unit_normals(as_floats(normals, "normals")))
    return _unnamed(as_floats(points, "points"), pick)


def _cloud(points: Array, normals: Array | None = None) -> Cloud:
    return Cloud(points, XYZ.names, normals, FORMAT)


def _unnamed(values: Array, pick: Pick) -> Cloud:
    """Points, and normals where they are asked for, of an array (N, C) or (H, W, C), by the rules of files.

    What is no such array, or looks transposed, is left for the check of the points to refuse.
    """
    if values.ndim not in (2, 3) or values.shape[-1] < 3 or is_transposed(values.shape):
        return _cloud(values)
    try:
        return read_table(values, FORMAT, pick)
    except UnreadableFileError as error:
        raise _refused(error) from error


def _held(given: Any) -> tuple[Any, Any]:
    """Points and normals as the object has them; the object itself where it holds no points."""
    if isinstance(given, np.ndarray | list | tuple):
        return given, None
    if hasattr(given, "points"):
        has_normals = getattr(given, "has_normals", None)
        return given.points, given.normals if has_normals and has_normals() else None
    if hasattr(given, "vertices"):
        return given.vertices, None
    return _tensors(given)


def _tensors(given: Any) -> tuple[Any, Any]:
    """Of Open3D's classes of tensors."""
    tensors = getattr(given, "point", getattr(given, "vertex", None))
    if tensors is None or "positions" not in tensors:
        return given, None
    mesh = hasattr(given, "vertex")
    return tensors["positions"], tensors["normals"] if "normals" in tensors and not mesh else None


def _column_names(given: Any) -> list[str]:
    """Names of the columns of a table or of the fields of records; none where one of them is no string."""
    names = getattr(getattr(given, "dtype", None), "names", None) or getattr(given, "columns", [])
    return [] if any(not isinstance(name, str) for name in names) else list(names)


def _columns(given: Any, names: list[str], pick: Pick) -> Cloud:
    try:
        columns = find_columns(names, pick)
    except UnreadableFileError as error:
        raise _refused(error) from error
    rows = given.reshape(-1) if isinstance(given, np.ndarray) else given  # organized records (H, W)
    values = np.column_stack([_one_a_point(rows[names[i]], f"points[{names[i]!r}]") for i in columns.used])
    return _cloud(values[:, :3], unit_normals(values[:, 3:], values[:, :3]) if columns.normals else None)


def _one_a_point(values: Any, field: str) -> Array:
    floats = as_floats(values, field)
    if floats.ndim != 1:
        raise InvalidPointCloudError(f"{field}: the column holds several numbers a point", "points")
    return floats


def _refused(error: UnreadableFileError) -> ValueError:
    """The complaint about columns that are asked for, or about points that have none."""
    if error.field == "columns":
        return InvalidOptionError(f"columns: {error}", "columns")
    return InvalidPointCloudError(f"points: {error}")


def as_floats(values: Any, field: str) -> Array:
    """An array of float64, NaN where it is masked.

    Raises `InvalidPointCloudError` for what is no array of numbers.
    """
    try:
        array = as_array(values)
        if array.ndim and array.dtype.kind in _NUMBERS:
            floats = np.asarray(array, np.float64)
            return np.where(values.mask, np.nan, floats) if np.ma.isMaskedArray(values) else floats
    except (TypeError, ValueError, RuntimeError) as error:
        raise _no_numbers(values, field) from error
    raise _no_numbers(values, field)


def as_array(values: Any) -> NDArray[Any]:
    """An array of any type; of a tensor its values, from whatever device and without its gradient."""
    if hasattr(values, "detach"):
        values = values.detach()
    if hasattr(values, "cpu"):
        values = values.cpu()
    return values.numpy() if hasattr(values, "numpy") else np.asarray(values)


def _no_numbers(values: Any, field: str) -> InvalidPointCloudError:
    wanted = f"; {WANTED}" if field == "points" else ""
    return InvalidPointCloudError(
        f"{field}: {type(values).__name__} is not an array of numbers{wanted}", field
    )
