"""The JSON body {"points": [[x, y, z], ...], "weights": [...], "options": {...}}: strict, quick to refuse.

Points and what stands beside them are rows, or base64 arrays (`app.readers.encoded`).
"""

import json
import re
from itertools import chain
from typing import Any

import numpy as np
import orjson
from numpy.typing import NDArray

from .cloud import Array, Cloud, string_labels
from .columns import FOUND, Pick, check_no_columns, find_label
from .encoded import INTEGERS, decode
from .errors import SHOWN, FieldError, InvalidPointsError, TooLargeError, UnreadableFileError, describe
from .limits import UNLIMITED, Limits

_TOKEN = re.compile(r'[\[\]{},:]|"[^"\\]*(?:\\.[^"\\]*)*"')
_NOT_FINITE = re.compile(r"(?P<nan>-?nan)|(?P<inf>[-+]?inf)", re.IGNORECASE)
_FEW = 16
_COORDINATE = {int, float, type(None)}
# As Python's own writer spells them.
_VECTORS = ("points", "normals")
_LITERALS = re.compile(r"-?(?:NaN|Infinity)\b")
_PER_POINT = ("weights", "standard_deviations")
_BESIDE = ("normals", "labels", *_PER_POINT)
_FIELDS = ("points", *_BESIDE, "options")
_NUMBER = re.compile(r"[-+]?\d[\d.eE+-]*")


def read_json(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read a JSON request: the points, what stands beside them, and the options as they are (unchecked).

    Labels that are not asked for are checked all the same.
    """
    body = bytes(data).removeprefix(b"\xef\xbb\xbf")
    # A shorter body has not enough characters for more values than are allowed.
    if limits.json_points is not None and len(body) > limits.json_points:
        _check_size(body, limits.json_points)
    document = _fields(_parse(body))
    options = {} if document.get("options") is None else document["options"]
    if not isinstance(options, dict):
        raise UnreadableFileError("options", "options must be an object", describe(options))
    _refuse_twice(body, [*document, *options])
    asked = options.get("columns") if pick.columns is None else pick.columns
    check_no_columns(Pick(columns=asked), "JSON")
    points = to_points(document["points"], limits)
    beside = _beside(document, points, limits)
    columns = ("x", "y", "z", *(name for name in beside if name != "labels"))
    normals, found = beside.pop("normals", None), beside.pop("labels", None)
    label = None if find_label(("labels",) if found is not None else (), pick.labels) is None else "labels"
    found = None if label is None else found
    return Cloud(points, columns, normals, "json", options, **beside, labels=found, label_column=label)


def _fields(document: object) -> dict[str, Any]:
    """The fields of a request, all of them known and the points among them."""
    if not isinstance(document, dict):
        raise UnreadableFileError("body", 'the body must be an object {"points": [...]}', describe(document))
    unknown = [name for name in document if name not in _FIELDS]
    if unknown:
        allowed = f"unknown field; allowed are {', '.join(_FIELDS)}"
        errors = [FieldError(name[:40], allowed) for name in unknown]
        told = ", ".join(f"{name!r:.40}" for name in unknown[:3]) + (", ..." if len(unknown) > 3 else "")
        message = f"unknown fields: {told}; allowed are {', '.join(_FIELDS)}"
        raise UnreadableFileError("body", message, errors=errors)
    if "points" not in document:
        raise UnreadableFileError("points", "points is missing", "missing")
    return document


def _beside(document: dict[str, Any], points: Array, limits: Limits) -> dict[str, Any]:
    """What stands beside the points, as arrays by their names."""
    given = {name: document[name] for name in _BESIDE if document.get(name) is not None}
    read = {"normals": _to_normals, "labels": _to_labels}
    return {
        name: read[name](values, points, limits) if name in read else _to_numbers(name, values, limits)
        for name, values in given.items()
    }


def _to_numbers(name: str, values: object, limits: Limits) -> Array:
    """Numbers, one a point, as an array; how many, and of what size, the fit checks."""
    if isinstance(values, dict):
        return decode(values, name, limits).astype(np.float64)
    if not isinstance(values, list):
        raise InvalidPointsError(name, f"{name} must be an array of numbers, one a point", describe(values))
    if not set(map(type, values)) <= {int, float}:
        i, bad = next((i, value) for i, value in enumerate(values) if type(value) not in (int, float))
        raise InvalidPointsError(f"{name}[{i}]", f"{name} must be numbers", describe(bad))
    return np.array(values, np.float64)


def _to_normals(rows: object, points: Array, limits: Limits) -> Array:
    """Normals (N, 3), scaled to length 1; a point that is missing needs none."""
    normals = _to_rows(rows, "normals", limits)
    _check_count("normals", len(normals), len(points))
    with np.errstate(all="ignore"):
        normals = normals / np.abs(normals).max(axis=1, keepdims=True, initial=0.0)
        bad = np.flatnonzero(~np.isfinite(normals).all(axis=1) & np.isfinite(points).all(axis=1))
    if len(bad):
        errors = [FieldError(f"normals[{i}]", "a normal must not be zero") for i in bad[:SHOWN]]
        raise InvalidPointsError(errors[0].field, f"{len(bad)} normals have no direction", errors=errors)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _to_labels(values: object, points: Array, limits: Limits) -> NDArray[Any]:
    """Labels (N,): integers, or strings."""
    kinds = set(map(type, values)) if isinstance(values, list) else None
    if isinstance(values, dict):
        labels = decode(values, "labels", limits, dtypes=INTEGERS).astype(np.int64)
    elif isinstance(values, list) and kinds == {str}:
        labels = string_labels(values)
    elif isinstance(values, list) and kinds == {int} and -(2**63) <= min(values) <= max(values) < 2**63:
        labels = np.array(values, np.int64)
    else:
        message = "labels must be an array, all integers of 64 bits or all strings"
        raise InvalidPointsError("labels", message, describe(values))
    _check_count("labels", len(labels), len(points))
    return labels


def _check_count(name: str, n_found: int, n_points: int) -> None:
    if n_found != n_points:
        raise InvalidPointsError(name, f"{n_found} {name} for {n_points} points", f"array of {n_found}")


def _refuse_twice(body: bytes, names: list[str]) -> None:
    """The parser keeps the last of two fields of one name; which one was meant, nobody can tell."""
    for name in names[:_FEW]:
        quoted = f'"{name}"'.encode()
        if body.count(quoted) > 1 and len(re.findall(re.escape(quoted) + rb"\s*:", body)) > 1:
            raise UnreadableFileError(name[:40], "given more than once")


def to_points(rows: object, limits: Limits = UNLIMITED) -> Array:
    """Rows [x, y, z] or a base64 array as an array (N, 3), null as NaN; what is no such row is named."""
    return _to_rows(rows, "points", limits)


def _to_rows(rows: object, field: str, limits: Limits) -> Array:
    if isinstance(rows, dict):
        return decode(rows, field, limits, width=3).astype(np.float64)
    if not isinstance(rows, list):
        raise InvalidPointsError(field, f"{field} must be an array of [x, y, z]", describe(rows))
    Limits(limits.json_points).check_points(len(rows), field)
    if set(map(type, rows)) <= {list} and set(map(len, rows)) <= {3}:
        values = list(chain.from_iterable(rows))
        if set(map(type, values)) <= _COORDINATE:
            return np.array(values, np.float64).reshape(-1, 3)
    raise _explain(rows, field)


def _explain(rows: list[Any], field: str) -> InvalidPointsError:
    errors: list[FieldError] = []
    n_bad = 0
    for i, row in enumerate(rows):
        if type(row) is list and len(row) == 3 and all(type(value) in _COORDINATE for value in row):
            continue
        n_bad += 1
        if len(errors) < SHOWN:
            errors += _explain_row(f"{field}[{i}]", row)
    message = f"{n_bad} of {len(rows)} {field} are not [x, y, z] with three numbers"
    return InvalidPointsError(errors[0].field, message, errors=errors)


def _explain_row(field: str, row: Any) -> list[FieldError]:
    if type(row) is not list or len(row) != 3:
        return [FieldError(field, "it must be an array of 3 numbers", describe(row))]
    return [
        FieldError(f"{field}[{j}]", "a coordinate must be a number", describe(value))
        for j, value in enumerate(row)
        if type(value) not in _COORDINATE
    ]


def _check_size(body: bytes, max_points: int) -> None:
    """Refuse, before it is parsed, a document that holds more values than the points allowed."""
    for what, n_found, limit in (
        ("arrays", body.count(b"["), 2 * max_points + 1000),
        ("values", body.count(b","), 8 * max_points + 1000),
        ("strings", body.count(b'"') // 2, max_points + 1000),
        ("objects", body.count(b"{"), max_points + 1000),
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
        found = _locate(error)
        if not (_LITERALS.match(error.doc, error.pos) and found.field.startswith(_VECTORS)):
            raise found from None
    return _parse_literals(body)


def _parse_literals(body: bytes) -> Any:
    """A document that is no JSON, because of NaN and Infinity among its coordinates."""
    try:
        return json.loads(body.decode(), parse_int=_whole)
    except (ValueError, RecursionError):
        raise UnreadableFileError("body", "not valid JSON, even with NaN and Infinity allowed") from None


def _whole(digits: str) -> int | float:
    """An integer of 64 bits, or a float, as the other parser has it."""
    return int(digits) if len(digits) < 20 else float(digits)


def _locate(error: orjson.JSONDecodeError) -> UnreadableFileError:
    """The parser's complaint as a field: where in the document, and which class of value stands there."""
    rest = error.doc[error.pos : error.pos + 10]
    path = _path(error.doc[: error.pos]) or "body"
    refused = InvalidPointsError if path.startswith(("points", *_BESIDE)) else UnreadableFileError
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
    """The path of the value that starts where `before`, a valid beginning of a document, ends.

    Where that is within a string, what the string holds may look like the end of all: there the path ends.
    """
    stack: list[int | str] = []
    last = ""
    for token in _TOKEN.finditer(before):
        if not stack and token[0] in ("]", "}", ",", ":"):
            break
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
