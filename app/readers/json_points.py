"""The JSON body {"points": [[x, y, z], ...], "weights": [...], "options": {...}}: strict, quick to refuse."""

import re
from itertools import chain
from typing import Any

import numpy as np
import orjson

from app.readers.cloud import Array, Cloud
from app.readers.errors import (
    SHOWN,
    FieldError,
    InvalidPointsError,
    TooLargeError,
    UnreadableFileError,
    describe,
)
from app.readers.limits import UNLIMITED, Limits

_TOKEN = re.compile(r'[\[\]{},:]|"[^"\\]*(?:\\.[^"\\]*)*"')
_NOT_FINITE = re.compile(r"(?P<nan>-?nan)|(?P<inf>[-+]?inf)", re.IGNORECASE)
_FEW = 16
_PER_POINT = ("weights", "standard_deviations")
_FIELDS = ("points", *_PER_POINT, "options")
_NUMBER = re.compile(r"[-+]?\d[\d.eE+-]*")


def read_json(data: memoryview, limits: Limits = UNLIMITED) -> Cloud:
    """Read a JSON request: the points, what stands beside them, and the options as they are (unchecked)."""
    body = bytes(data).removeprefix(b"\xef\xbb\xbf")
    if limits.json_points is not None:
        _check_size(body, limits.json_points)
    document = _parse(body)
    if not isinstance(document, dict):
        raise UnreadableFileError("body", 'the body must be an object {"points": [...]}', describe(document))
    unknown = [name for name in document if name not in _FIELDS]
    if unknown:
        allowed = f"unknown field; allowed are {', '.join(_FIELDS)}"
        errors = [FieldError(name[:40], allowed) for name in unknown]
        raise UnreadableFileError("body", f"fields that are not known: {len(unknown)}", errors=errors)
    if "points" not in document:
        raise UnreadableFileError("points", "points is missing", "missing")
    options = {} if document.get("options") is None else document["options"]
    if not isinstance(options, dict):
        raise UnreadableFileError("options", "options must be an object", describe(options))
    _refuse_twice(body, [*document, *options])
    points = to_points(document["points"], limits)
    beside: dict[str, Any] = {
        name: _to_numbers(name, document[name]) for name in _PER_POINT if document.get(name) is not None
    }
    return Cloud(points, ("x", "y", "z", *beside), None, "json", options, **beside)


def _to_numbers(name: str, values: object) -> Array:
    """Numbers, one a point, as an array; how many, and of what size, the fit checks."""
    if not isinstance(values, list):
        raise InvalidPointsError(name, f"{name} must be an array of numbers, one a point", describe(values))
    if not set(map(type, values)) <= {int, float}:
        i, bad = next((i, value) for i, value in enumerate(values) if type(value) not in (int, float))
        raise InvalidPointsError(f"{name}[{i}]", f"{name} must be numbers", describe(bad))
    return np.array(values, np.float64)


def _refuse_twice(body: bytes, names: list[str]) -> None:
    """The parser keeps the last of two fields of one name; which one was meant, nobody can tell."""
    for name in names[:_FEW]:
        if body.count(f'"{name}"'.encode()) > 1:
            raise UnreadableFileError(name[:40], "given more than once")


def to_points(rows: object, limits: Limits = UNLIMITED) -> Array:
    """Rows [x, y, z] as an array (N, 3); what is not three numbers is named."""
    if not isinstance(rows, list):
        raise InvalidPointsError("points", "points must be an array of [x, y, z]", describe(rows))
    Limits(limits.json_points).check_points(len(rows), "points")
    if set(map(type, rows)) <= {list} and set(map(len, rows)) <= {3}:
        values = list(chain.from_iterable(rows))
        if set(map(type, values)) <= {int, float}:
            return np.array(values, np.float64).reshape(-1, 3)
    raise _explain(rows)


def _explain(rows: list[Any]) -> InvalidPointsError:
    errors: list[FieldError] = []
    n_bad = 0
    for i, row in enumerate(rows):
        if type(row) is list and len(row) == 3 and all(type(value) in (int, float) for value in row):
            continue
        n_bad += 1
        if len(errors) < SHOWN:
            errors += _explain_row(i, row)
    message = f"{n_bad} of {len(rows)} points are not [x, y, z] with three numbers"
    return InvalidPointsError(errors[0].field, message, errors=errors)


def _explain_row(i: int, row: Any) -> list[FieldError]:
    if type(row) is not list or len(row) != 3:
        return [FieldError(f"points[{i}]", "a point must be an array of 3 numbers", describe(row))]
    return [
        FieldError(f"points[{i}][{j}]", "a coordinate must be a number", describe(value))
        for j, value in enumerate(row)
        if type(value) not in (int, float)
    ]


def _check_size(body: bytes, max_points: int) -> None:
    """Refuse, before it is parsed, a document that holds more values than the points allowed."""
    for what, n_found, limit in (
        ("arrays", body.count(b"["), max_points + 1000),
        ("values", body.count(b","), 4 * max_points + 1000),
    ):
        if n_found > limit:
            raise TooLargeError(
                "points",
                f"{n_found} {what}; the limit is {max_points} points in JSON, send more as CSV, NPY or PLY",
                f"{n_found} {what}",
            )


def _parse(body: bytes) -> Any:
    try:
        return orjson.loads(body)
    except orjson.JSONDecodeError as error:
        raise _locate(error) from None


def _locate(error: orjson.JSONDecodeError) -> UnreadableFileError:
    """The parser's complaint as a field: where in the document, and which class of value stands there."""
    rest = error.doc[error.pos : error.pos + 10]
    path = _path(error.doc[: error.pos]) or "body"
    refused = InvalidPointsError if path.startswith(("points", *_PER_POINT)) else UnreadableFileError
    if number := _NOT_FINITE.match(rest):
        value = "NaN" if number["nan"] else "infinity"
        return refused(path, f"{value} is not JSON; every number must be finite", value)
    if "infinity" in error.msg:
        found = _NUMBER.match(error.doc, error.pos)
        digits = len(found[0]) if found else 0
        return refused(
            path,
            "the number is beyond the range of a 64-bit float (1.8e308)",
            f"number of {digits} characters",
        )
    if "depth" in error.msg:
        return UnreadableFileError("body", "the JSON is nested more than 1024 deep")
    return UnreadableFileError(path, f"not valid JSON at character {error.pos}")


def _path(before: str) -> str:
    """The path of the value that starts where `before`, a valid beginning of a document, ends."""
    stack: list[int | str] = []
    last = ""
    for token in _TOKEN.finditer(before):
        match token[0]:
            case "[":
                stack.append(0)
            case "{":
                stack.append("")
            case "]" | "}":
                stack.pop()
            case ",":
                place = stack[-1]
                stack[-1] = place + 1 if isinstance(place, int) else ""
            case ":":
                stack[-1] = last[1:-1][:40]
            case string:
                last = string
    return "".join(f"[{place}]" if isinstance(place, int) else f".{place}" for place in stack[:8]).lstrip(".")
