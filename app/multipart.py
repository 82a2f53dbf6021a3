"""The parts of a multipart/form-data body: `file`, and `options` where there are any."""

from python_multipart.exceptions import FormParserError
from python_multipart.multipart import MultipartParser, parse_options_header

from app.readers.errors import UnreadableFileError

PARTS = ("file", "options")


def split_parts(body: bytes | memoryview, content_type: str) -> dict[str, memoryview]:
    """The content of each part by its name, without a copy; each may be there once."""
    boundary = parse_options_header(content_type)[1].get(b"boundary")
    if not boundary or len(boundary) > 70:
        raise UnreadableFileError(
            "Content-Type", "multipart/form-data needs a boundary of 1 to 70 characters"
        )
    body = bytes(body)
    parts = _Parts()
    parser = MultipartParser(boundary, parts.callbacks())  # type: ignore[arg-type]
    try:
        parser.write(body)
        parser.finalize()
    except FormParserError:
        parts.complete = False
    if not parts.complete:
        raise UnreadableFileError("body", "the multipart body is not well-formed, or ends early")
    view = memoryview(body)
    return {name: view[start:end] for name, (start, end) in parts.spans.items()}


class _Parts:
    """Called back by the parser: the first and last byte of each part."""

    def __init__(self) -> None:
        self.spans: dict[str, tuple[int, int]] = {}
        self.complete = False
        self._name = ""
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
        name = parse_options_header(self._disposition)[1].get(b"name", b"").decode("utf-8", "replace")
        self._disposition = b""
        if name not in PARTS:
            raise UnreadableFileError(name[:40] or "body", f"unknown part; allowed are {', '.join(PARTS)}")
        if name in self.spans:
            raise UnreadableFileError(name, f"part {name} is given more than once")
        self._name = name
        self.spans[name] = (0, 0)

    def _add_data(self, _: bytes, start: int, end: int) -> None:
        first = self.spans[self._name][0]
        self.spans[self._name] = (first or start, end)

    def _end(self) -> None:
        self.complete = True
