"""What worker processes do with a batch: find its files, read each of them, fit each segment."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from ..engine.answer import to_json
from ..engine.cut import Cut, Label, Stored, cut_cloud, store
from ..engine.fit import config_of, prepared
from ..readers import (
    Cloud,
    FieldError,
    Limits,
    Pick,
    TooLargeError,
    UnreadableFileError,
    read,
    read_json,
    read_unpacked,
    unpack,
)
from ..readers.columns import AUTO_LABELS, as_columns
from ..wire.multipart import Part, find_parts
from ..wire.options import check_options, parse_options
from ..wire.problems import InvalidOptionsError
from .jobs import fitted
from .trace_context import TRACE_ID

PARTS = ("file", "options", "labels")
_LABELS_LENGTH = 200


@dataclass(frozen=True)
class Stretch:
    """Bytes of a file on disk."""

    path: Path
    start: int
    stop: int

    def read(self) -> bytes:
        with self.path.open("rb") as file:
            file.seek(self.start)
            return file.read(self.stop - self.start)


@dataclass(frozen=True)
class Options:
    """What stands in the query and in the part `options`, checked, but not merged yet with a file's own."""

    query: list[tuple[str, str]]
    beside: Mapping[str, Any]


@dataclass(frozen=True)
class Opened:
    """The files of a batch in their order, the column of labels to cut them by, and the options of all.

    Where the body was `unpacked` they stand in what it held.
    """

    files: list[Part]
    unpacked: bool
    labels: str | None
    options: Options


@dataclass(frozen=True)
class Found:
    """A finished answer, and the facts of it: `jobs.fitted`."""

    content: bytes
    facts: Mapping[str, Any]


@dataclass(frozen=True)
class CutFile:
    """The labels of a file that was cut; the rows stored between two `bounds` are the segment of each."""

    labels: list[Label]
    bounds: list[int]
    stored: Stored
    options: Mapping[str, Any]


@dataclass(frozen=True)
class OpenJob:
    """A batch as the service received it; a large body stands in a file."""

    request_id: str
    body: bytes | Path
    media_type: str
    content_type: str
    coding: str | None
    unpacked: Path | None
    query: list[tuple[str, str]]
    limits: Limits
    most_files: int
    trace_id: str | None = field(default_factory=TRACE_ID.get, kw_only=True)

    def work(self) -> Opened:
        """Which files there are, with options that hold for all of them."""
        body = self._unpacked()
        parts = self._parts(body)
        files = [part for part in parts if part.name == "file"]
        if not files:
            raise UnreadableFileError("file", "part file is missing", "missing")
        beside = {part.name: bytes(body[part.start : part.stop]) for part in parts if part.name != "file"}
        labels = _labels(self.query, beside.get("labels"))
        query = [pair for pair in self.query if pair[0] != "labels"]
        options = Options(query, parse_options(beside["options"]) if "options" in beside else {})
        config_of(**check_options(options.query, options.beside))
        return Opened(files, self.coding is not None, labels, options)

    def _parts(self, body: bytes | memoryview) -> list[Part]:
        """Those of the body; without a form it is one file."""
        if self.media_type == "multipart/form-data":
            return find_parts(body, self.content_type, PARTS, self.most_files)
        if not body:
            raise UnreadableFileError("body", "the body is empty", "empty")
        return [Part("file", None, 0, len(body))]

    def _unpacked(self) -> bytes | memoryview:
        """The body; if it came packed, what it holds is written to the file `unpacked`, too."""
        body = self.body if isinstance(self.body, bytes) else self.body.read_bytes()
        if self.coding is None or self.unpacked is None:
            return body
        with self.unpacked.open("r+b") as file:
            held = unpack(memoryview(body), self.coding, self.limits, "body")
            file.write(held)
        return held


def _labels(query: list[tuple[str, str]], in_part: bytes | None) -> str | None:
    """The name of the column of labels; an empty one asks for none."""
    in_query = [value for name, value in query if name == "labels"]
    given = [*in_query, *([] if in_part is None else [in_part.decode("utf-8", "replace")])]
    if len(given) > 1:
        raise InvalidOptionsError([FieldError("labels", "given more than once")])
    if given and len(given[0]) > _LABELS_LENGTH:
        raise InvalidOptionsError([FieldError("labels", f"over {_LABELS_LENGTH} characters long")])
    return (given[0].strip() or None) if given else AUTO_LABELS


@dataclass(frozen=True)
class FileJob:
    """A file of a batch, and an empty file to keep the points of its segments in."""

    request_id: str
    content: bytes | Stretch
    media_type: str
    unpacked: bool
    labels: str | None
    options: Options
    limits: Limits
    scratch: Path
    most_segments: int
    trace_id: str | None = field(default_factory=TRACE_ID.get, kw_only=True)

    def work(self) -> Found | CutFile:
        """The answer for a file without labels; of one that has them the segments, cut but not fitted."""
        # Opened first: when the request is given up, the file goes, and is not made again.
        with self.scratch.open("r+b") as scratch:
            options = check_options(self.options.query, self.options.beside)
            cloud = self._read(Pick(self.labels, as_columns(options.get("columns"))))
            if cloud.options:
                options = check_options(self.options.query, self.options.beside, cloud.options)
            cut = cut_cloud(cloud)
            return _found(cloud, options, self.limits) if cut is None else self._store(cut, options, scratch)

    def _read(self, pick: Pick) -> Cloud:
        content = self.content if isinstance(self.content, bytes) else self.content.read()
        if self.media_type == "application/json":
            return read_json(memoryview(content), self.limits, pick)
        return (read_unpacked if self.unpacked else read)(memoryview(content), self.limits, pick)

    def _store(self, cut: Cut, options: Mapping[str, Any], scratch: BinaryIO) -> CutFile:
        if len(cut.labels) > self.most_segments:
            raise too_many_segments(len(cut.labels), self.most_segments)
        return CutFile(cut.labels, cut.bounds, store(cut, self.scratch, scratch), options)


def too_many_segments(n_segments: int, limit: int) -> TooLargeError:
    """The complaint about a file that holds more than the items that are left."""
    return TooLargeError(
        "labels", f"{n_segments} segments; this request may hold {limit} more", f"{n_segments} segments"
    )


@dataclass(frozen=True)
class SegmentJob:
    """A segment of a file that was cut."""

    request_id: str
    stored: Stored
    options: Mapping[str, Any]
    limits: Limits
    start: int
    stop: int
    trace_id: str | None = field(default_factory=TRACE_ID.get, kw_only=True)

    def work(self) -> Found:
        """The answer for the segment: that for a file of its rows alone."""
        return _found(self.stored.segment(self.start, self.stop), self.options, self.limits)


def _found(cloud: Cloud, options: Mapping[str, Any], limits: Limits) -> Found:
    _, content, facts = fitted(prepared(cloud, options), options, limits)
    return Found(to_json(content), facts)
