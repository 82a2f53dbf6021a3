"""The parts of a multipart/form-data body: `file`, and `options` where there are any."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from python_multipart.exceptions import FormParserError
from python_multipart.multipart import MultipartParser, parse_options_header

from ..readers.errors import TooLargeError, UnreadableFileError

PARTS = ("file", "options")


@dataclass
class Part:
    """A part: its name, the file name that came with it, and where its content stands in the body."""

    name: str
    filename: str | None
    start: int = 0
    stop: int = 0


def split_parts(body: bytes | memoryview, content_type: str) -> tuple[dict[str, memoryview], str | None]:
    """The content of each part by its name, without a copy, and the file name that came with the file."""
    view, parts = memoryview(body), find_parts(body, content_type)
    name = next((part.filename for part in parts if part.name == "file"), None)
    return {part.name: view[part.start : part.stop] for part in parts}, name


def find_parts(
    body: bytes | memoryview, content_type: str, allowed: Sequence[str] = PARTS, most_files: int = 1
) -> list[Part]:
    """The parts of a body in their order; each may be there once, but for `file`."""
    boundary = parse_options_header(content_type)[1].get(b"boundary")
    if not boundary or len(boundary) > 70:
        raise UnreadableFileError(
            "Content-Type", "multipart/form-data needs a boundary of 1 to 70 characters"
        )
    body = bytes(body)
    parts = _Parts(allowed, most_files)
    parser = MultipartParser(boundary, parts.callbacks())  # type: ignore[arg-type]
    try:
        parser.write(body)
        parser.finalize()
    except FormParserError:
        parts.complete = False
    if not parts.complete:
        raise UnreadableFileError("body", "the multipart body is not well-formed, or ends early")
    return parts.found


class _Parts:
    """Called back by the parser: which parts there are, and where."""

    def __init__(self, allowed: Sequence[str], most_files: int) -> None:
        self.found: list[Part] = []
        self.complete = False
        self._allowed, self._most = allowed, {"file": most_files}
        self._counts: Counter[str] = Counter()
        self._header: dict[str, bytes] = {"field": b"", "value": b""}
        self._disposition = b""

    def callbacks(self) -> dict[str, object]:
        return {
            "on_header_field": lambda data, start, end: self._extend("field", data[start:end]),
            "on_header_value": lambda data, start, end: self._extend("value", data[start:end]),
            "on_header_end": self._end_header,
            "on_headers_finished": self._begin_part,
            "on_part_data": self._add_data,
            "on_end": self._end,
        }

    def _extend(self, what: str, data: bytes) -> None:
        self._header[what] += data

    def _end_header(self) -> None:
        if self._header["field"].lower() == b"content-disposition":
            self._disposition = self._header["value"]
        self._header = {"field": b"", "value": b""}

    def _begin_part(self) -> None:
        parameters = parse_options_header(self._disposition)[1]
        name = parameters.get(b"name", b"").decode("utf-8", "replace")
        filename = parameters.get(b"filename")
        self._disposition = b""
        if name not in self._allowed:
            raise UnreadableFileError(
                name[:40] or "body", f"unknown part; allowed are {', '.join(self._allowed)}"
            )
        self._counts[name] += 1
        if self._counts[name] > (most := self._most.get(name, 1)):
            if most > 1:
                raise TooLargeError(name, f"more than {most} files, the limit of a request")
            raise UnreadableFileError(name, f"part {name} is given more than once")
        self.found.append(Part(name, None if filename is None else filename.decode("utf-8", "replace")))

    def _add_data(self, _: bytes, start: int, end: int) -> None:
        part = self.found[-1]
        part.start, part.stop = part.start or start, end

    def _end(self) -> None:
        self.complete = True
