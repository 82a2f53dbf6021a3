"""A cloud whose points carry labels, cut into its segments; and each of them fitted, in Python."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from primfit.fitting.answer.result import Recognition
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError

from ..readers.cloud import Cloud
from .answer import to_json
from .arrays import as_array, as_cloud, as_floats
from .fit import config_of, fit_cloud

PER_POINT = ("points", "normals", "weights", "standard_deviations")

Label = int | str
Rows = NDArray[np.intp]


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
            yield label, rows, part(self.cloud, rows)


@dataclass(frozen=True)
class Segment:
    """A segment that was fitted: its label, its rows in the cloud, and the `recognition`.

    Where it could not be fitted `recognition` is None and `problem` says why; it is empty otherwise.
    """

    label: Label
    rows: Rows
    recognition: Recognition | None
    problem: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Plain values, the recognition as in `Recognition.to_dict`."""
        return {
            "label": self.label,
            "rows": self.rows.tolist(),
            "recognition": self.recognition and self.recognition.to_dict(),
            "problem": self.problem,
        }

    def to_json(self) -> str:
        """`to_dict` in one line of JSON."""
        return to_json(self.to_dict()).decode()

    def __str__(self) -> str:
        return f"segment {self.label}, {len(self.rows)} points: {self.recognition or self.problem}"

    def __repr__(self) -> str:
        return f"<Segment {self.label!r}, {len(self.rows)} points: {(self.recognition or self.problem)!r}>"


def fit_segments(points: Any, labels: ArrayLike, **options: Any) -> list[Segment]:
    """`fit` each segment of a cloud: the points of one label.

    Parameters
    ----------
    points : (N, 3), any unit of length: whatever `fit` takes
    labels : (N,) whole numbers or strings
    options : those of `fit`; `normals`, `weights` and `standard_deviations` have a value for each point

    Returns
    -------
    The segments by label, in ascending order. One that cannot be fitted, with two points, say, has a
    `problem` and no `recognition`; it does not keep the others from theirs.

    Raises
    ------
    InvalidPointCloudError
        There are not as many labels, normals or weights as points, or labels are neither whole numbers nor
        strings.
    InvalidOptionError
        An option is unknown or out of range.
    """
    given = {name: options.pop(name, None) for name in PER_POINT[1:]}
    config_of(**options)
    coordinates, held = as_cloud(points)
    arrays: dict[str, Any] = {
        name: as_floats(values, name) for name, values in given.items() if values is not None
    }
    whole = Cloud(coordinates, ("x", "y", "z"), held, "array", labels=as_array(labels))
    segments = []
    for label, rows, cloud in cut(replace(whole, **arrays)):
        try:
            segments.append(Segment(label, rows, fit_cloud(cloud, options)))
        except (InvalidPointCloudError, InvalidOptionError) as error:
            segments.append(Segment(label, rows, None, str(error)))
    return segments


def cut_cloud(cloud: Cloud) -> Cut | None:
    """The segments of a cloud; None where it has no labels, or no points that could carry them."""
    return None if cloud.labels is None or not len(cloud.labels) else cut(cloud)


def cut(cloud: Cloud) -> Cut:
    """The segments of a cloud that has labels (N,).

    Raises `InvalidPointCloudError` where labels are no whole numbers or strings, or lengths differ.
    """
    assert cloud.labels is not None
    labels, arrays = _whole(cloud.labels), per_point(cloud)
    n_points = len(arrays["points"]) if arrays["points"].ndim else 0
    for name, array in {"labels": labels, **arrays}.items():
        if array.shape[:1] != (n_points,):
            raise InvalidPointCloudError(
                f"{name} have shape {array.shape}; one for each of {n_points} points is needed", name
            )
    values, which, counts = _distinct(labels)
    return Cut(cloud, values, np.argsort(which, kind="stable"), [0, *np.cumsum(counts).tolist()])


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


def _distinct(labels: NDArray[Any]) -> tuple[list[Label], Rows, Rows]:
    """The labels there are, ascending; which of them each point has; and how many points each has."""
    if labels.dtype.kind in "iu":
        numbers, which, counts = np.unique(labels, return_inverse=True, return_counts=True)
        return numbers.tolist(), which, counts
    # Quicker than to sort all the strings.
    names = sorted(set(labels.tolist()))
    place = {name: i for i, name in enumerate(names)}
    which = np.fromiter(map(place.__getitem__, labels.tolist()), np.intp, len(labels))
    return names, which, np.bincount(which, minlength=len(names))


def per_point(cloud: Cloud) -> dict[str, NDArray[np.float64]]:
    """What a cloud holds for each of its points, but for the labels, by name."""
    given = {name: getattr(cloud, name) for name in PER_POINT}
    return {name: values for name, values in given.items() if values is not None}


def part(cloud: Cloud, rows: Rows) -> Cloud:
    """The cloud of some of the points, without labels: what a file of these rows alone is read as."""
    chosen: dict[str, Any] = {name: values[rows] for name, values in per_point(cloud).items()}
    return replace(cloud, **chosen, labels=None, label_column=None)
