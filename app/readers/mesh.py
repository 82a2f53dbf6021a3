"""What all meshes have in common: the points are their distinct vertices."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .cloud import Array, Cloud, build_cloud
from .columns import XYZ, Columns, Pick, check_no_columns
from .errors import InvalidPointsError
from .limits import Limits

_WITH_NORMALS = Columns(("x", "y", "z", "nx", "ny", "nz"), (0, 1, 2), (3, 4, 5))


def build_mesh(vertices: Array, normals: Array | None, format: str, limits: Limits, pick: Pick) -> Cloud:
    """The distinct vertices (N, 3) in the order of their first appearance.

    `normals` are kept where they are unambiguous: equal at all repeats of each vertex. Raises
    `InvalidPointsError` where there is no vertex, `UnreadableFileError` where columns or labels are asked
    for: a mesh has none.
    """
    check_no_columns(pick, "a mesh")
    if not len(vertices):
        raise InvalidPointsError("file", "the mesh holds no vertices")
    first, group = distinct(vertices)
    limits.check_points(len(first))
    if normals is None or not np.array_equal(normals[first][group], normals):
        return build_cloud(vertices[first], XYZ, format)
    return build_cloud(np.hstack([vertices[first], normals[first]]), _WITH_NORMALS, format)


def distinct(rows: NDArray[Any]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where each distinct row (N, 3) stands first, ascending, and for each row which of them it equals."""
    order = np.lexsort(rows.T)
    ordered = rows[order]
    starts = np.ones(len(rows), bool)
    starts[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    first = order[starts]  # lexsort is stable: of equal rows, the first in the file
    rank = np.empty(len(first), np.intp)
    rank[np.argsort(first)] = np.arange(len(first))
    group = np.empty(len(rows), np.intp)
    group[order] = rank[np.cumsum(starts) - 1]
    return np.sort(first), group
