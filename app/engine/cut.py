"""A cloud whose points carry labels, cut into its segments, and how any process has each of them."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from math import prod
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.errors import InvalidPointCloudError

from ..readers.cloud import Cloud, per_point, selected

Label = int | str
Rows = NDArray[np.intp]
Piece = Callable[[], Cloud]
"""How a segment is had; it may be sent to another process."""


@dataclass(frozen=True)
class Cut:
    """How a cloud falls into segments: by their labels, ascending.

    `rows` are those of the first segment in their order, then those of the second, and so on; the segment of
    the i-th label has those from `bounds[i]` to `bounds[i + 1]`.
    """

    cloud: Cloud
    labels: list[Label]
    rows: Rows
    bounds: list[int]

    def __iter__(self) -> Iterator[tuple[Label, Rows, Cloud]]:
        """Each label with its rows, and the cloud of these."""
        for label, (start, stop) in zip(self.labels, pairwise(self.bounds), strict=True):
            rows = self.rows[start:stop]
            yield label, rows, selected(self.cloud, rows, dropped={})


@dataclass(frozen=True)
class Stored:
    """The points of a cloud that was cut, in a file from which any process reads those of a segment.

    Attributes
    ----------
    path : of the file: float64, one array after the other, each segment by segment
    n_points : of all segments
    shapes : of what each array has for a point, by the name of the array: (3,) of points, () of weights
    cloud : what else is known
    """

    path: Path
    n_points: int
    shapes: Mapping[str, tuple[int, ...]]
    cloud: Cloud

    def segment(self, start: int, stop: int) -> Cloud:
        """The cloud of these rows."""
        arrays: dict[str, Any] = {}
        before = 0
        with self.path.open("rb") as file:
            for name, shape in self.shapes.items():
                width = prod(shape)
                file.seek(8 * (before + start * width))
                arrays[name] = np.fromfile(file, count=(stop - start) * width).reshape(-1, *shape)
                before += self.n_points * width
        return replace(self.cloud, **arrays)


def store(cut: Cut, path: Path, file: BinaryIO) -> Stored:
    """Write the points of a cut cloud to a file that is open at its beginning, and lies at `path`."""
    arrays = per_point(cut.cloud)
    for values in arrays.values():
        for start, stop in pairwise(cut.bounds):
            file.write(np.ascontiguousarray(values[cut.rows[start:stop]], np.float64).data)
    shapes = {name: values.shape[1:] for name, values in arrays.items()}
    return Stored(path, len(cut.rows), shapes, selected(cut.cloud, cut.rows[:0], dropped={}))


@dataclass(frozen=True)
class Held:
    """A segment of a cloud that this process holds; what is sent to another are the points of the segment."""

    cloud: Cloud
    rows: Rows

    def __call__(self) -> Cloud:
        return selected(self.cloud, self.rows, dropped={})

    def __reduce__(self) -> tuple[Any, ...]:
        return partial, (_itself, self())


def _itself(cloud: Cloud) -> Cloud:
    return cloud


def pieces(cut: Cut, scratch: Path | None = None) -> list[Piece]:
    """The segments of a cut cloud, in the order of their labels.

    With a `scratch` file the points are written to it, once, and any process may ask for its segment.
    """
    if scratch is None:
        rows = (cut.rows[start:stop] for start, stop in pairwise(cut.bounds))
        return [Held(cut.cloud, each) for each in rows]
    with scratch.open("wb") as file:
        stored = store(cut, scratch, file)
    return [partial(stored.segment, start, stop) for start, stop in pairwise(cut.bounds)]


def cut_cloud(cloud: Cloud) -> Cut | None:
    """The segments of a cloud; None where it has no labels, or no points that could carry them."""
    return None if cloud.labels is None or not len(cloud.labels) else cut(cloud)


def cut(cloud: Cloud) -> Cut:
    """The segments of a cloud that has labels (N,).

    Raises `InvalidPointCloudError` where labels are no whole numbers or strings, or lengths differ.
    """
    labels = labels_of(cloud)
    values, rows, starts = in_order(labels)
    return Cut(cloud, values, rows, [*starts.tolist(), len(labels)])


def labels_of(cloud: Cloud) -> NDArray[Any]:
    """The labels (N,) of a cloud that has some, as integers or strings; raises what `cut` does."""
    assert cloud.labels is not None
    labels, arrays = _whole(cloud.labels), per_point(cloud)
    n_points = len(arrays["points"]) if arrays["points"].ndim else 0
    for name, array in {"labels": labels, **arrays}.items():
        if array.shape[:1] != (n_points,):
            raise InvalidPointCloudError(
                f"{name} have shape {array.shape}; one for each of {n_points} points is needed", name
            )
    return labels


def _whole(labels: NDArray[Any]) -> NDArray[Any]:
    """Labels (N,) as integers or strings; floats that are whole numbers are taken for what they mean."""
    if labels.ndim != 1:
        raise InvalidPointCloudError(f"labels have shape {labels.shape}; (N,) is needed", "labels")
    kind = labels.dtype.kind
    if kind == "b" or (
        kind == "f" and (labels == np.rint(labels)).all() and (np.abs(labels) <= 2.0**53).all()
    ):
        return labels.astype(np.int64)
    if kind in "iuU" or (kind == "O" and set(map(type, labels)) <= {str}):
        return labels
    raise InvalidPointCloudError("labels must be whole numbers or strings", "labels")


def in_order(labels: NDArray[Any]) -> tuple[list[Label], Rows, Rows]:
    """The labels there are, ascending; the rows (N,), label by label; and where the rows of each begin."""
    if labels.dtype.kind in "iu":
        rows = np.argsort(_narrow(labels), kind="stable")
        starts = _starts(labels[rows])
        return labels[rows[starts]].tolist(), rows, starts
    # Quicker than to sort all the strings.
    names = sorted(set(labels.tolist()))
    place = {name: i for i, name in enumerate(names)}
    which = np.fromiter(map(place.__getitem__, labels.tolist()), np.intp, len(labels))
    rows = np.argsort(_narrow(which), kind="stable")
    return list(names), rows, _starts(which[rows])


def _narrow(numbers: NDArray[Any]) -> NDArray[Any]:
    """Whole numbers (N,) in the same order, as differences from the least in 16 bits where these suffice.

    NumPy sorts such numbers by their digits, some ten times as fast as it sorts others.
    """
    if not len(numbers) or int(numbers.max()) - int(numbers.min()) >= 2**16:
        return numbers
    return np.asarray(numbers.astype(np.uint16) - np.uint16(int(numbers.min()) % 2**16))


def _starts(ascending: NDArray[Any]) -> Rows:
    """Where each of the numbers that are there begins."""
    new = np.ones(len(ascending), bool)
    np.not_equal(ascending[1:], ascending[:-1], out=new[1:])
    return np.flatnonzero(new)
