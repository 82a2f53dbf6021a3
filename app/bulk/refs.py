"""A segment by reference, and how any process on any machine has its points."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..engine.cut import Label
from ..readers import Cloud, Pick, UnreadableFileError, read
from ..readers.columns import as_columns


@dataclass(frozen=True, slots=True)
class Ref:
    """A segment by reference: its id, where it comes from, and how any machine has its points.

    Attributes
    ----------
    id : unique in a run by construction: path or URL, `#label` behind it where there is one
    file : path or URL as the user knows it
    label : of the segment, where its file has several
    n_points : about, for sizing; exact where the points were counted
    store : where the points are, as any machine finds it: an absolute path or a URL; None: at `file`
    start, stop : its rows in the store; `stop` is 0 where the whole file is the cloud
    problem : field and message of what is wrong with it, and whether it is no cloud at all; None as a rule
    """

    id: str
    file: str
    label: Label | None
    n_points: int
    store: str | None = None
    start: int = 0
    stop: int = 0
    problem: tuple[str, str, bool] | None = None

    def to_plain(self) -> list[Any]:
        """What a line of a plan holds."""
        known = [self.id, self.file, self.label, self.n_points, self.store, self.start, self.stop]
        return known if self.problem is None else [*known, list(self.problem)]

    @classmethod
    def from_plain(cls, plain: list[Any]) -> "Ref":
        """The reference that `to_plain` gave."""
        id, file, label, n_points, store, start, stop, *problem = plain
        return cls(id, file, label, n_points, store, start, stop, tuple(problem[0]) if problem else None)


def file_id(file: str) -> str:
    """The id of a whole file; what stands behind a `#` of an id is a label."""
    return file.replace("%", "%25").replace("#", "%23")


def segment_id(file: str, label: Label) -> str:
    """The id of a segment of a file."""
    return f"{file_id(file)}#{label}"


def cloud_at(ref: Ref, options: Mapping[str, Any]) -> tuple[Cloud, dict[str, Any]]:
    """The points of a segment, and the options that hold for it: what `engine.answer.answered` takes.

    Raises
    ------
    UnreadableFileError, InvalidOptionError
        The bytes are no cloud, or the options in the file are none.
    OSError
        They cannot be read, after several attempts where a network lies between.
    """
    from . import grouping, parquet, places

    if ref.problem is not None:
        field, message, no_cloud = ref.problem
        raise UnreadableFileError(field, message, no_cloud=no_cloud)
    place = ref.store or ref.file
    if not ref.stop:
        return read_cloud(places.read_bytes(place), options)
    if grouping.is_store(place):
        cloud = grouping.segment(place, ref.start, ref.stop)
        return cloud, _with_options_of(cloud, options)
    return parquet.segment(place, ref.start, ref.stop, options.get("columns")), dict(options)


def read_cloud(
    data: bytes, options: Mapping[str, Any], labels: str | None = None
) -> tuple[Cloud, dict[str, Any]]:
    """The cloud that a file holds, and the options that hold for it."""
    cloud = read(data, pick=Pick(labels, as_columns(options.get("columns"))))
    return cloud, _with_options_of(cloud, options)


def _with_options_of(cloud: Cloud, given: Mapping[str, Any]) -> dict[str, Any]:
    """The options given, and those in the file: JSON may hold some, as the body of `POST /fit` does."""
    if not cloud.options:
        return dict(given)
    # Imported here, because few files hold options and the check brings half of the service along.
    from ..wire.options import check_options
    from ..wire.problems import InvalidOptionsError

    try:
        return check_options((), given, cloud.options)
    except InvalidOptionsError as error:
        bad = error.errors[0]
        raise UnreadableFileError(bad.field, bad.message) from None
