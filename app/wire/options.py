"""Options from a JSON object or a query string, checked and with every mistake named."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import orjson
from pydantic import ValidationError

from ..readers.errors import FieldError, UnreadableFileError, describe
from .problems import InvalidOptionsError, option_errors
from .schemas import FitOptions

ALLOWED = tuple(FitOptions.model_fields)
LISTS = ("kinds", "include", "columns")
COMMAS = ("columns",)
"""Lists that may stand in one parameter of a query, separated by commas."""

OBJECTS = ("constraints", "initial_guess", "nominal")
_TEXT_LIMIT = 64 * 1024
_MOST_VALUES = 10_000
"""In an object of options, at any depth: each unknown one would be looked at and told of."""


def check_options(
    in_query: Sequence[tuple[str, str]], *in_objects: Mapping[str, Any], beside: Sequence[str] = ()
) -> dict[str, Any]:
    """The keyword options of `engine.fit`; each is given in one place, and only lists may be repeated.

    Parameters
    ----------
    in_query : names and values as they stand in a URL, which holds no objects
    in_objects : objects of options, as in JSON: beside a file and in it
    beside : names in the query that somebody else has read already, to be named where one is unknown

    Raises
    ------
    UnreadableFileError
        An object holds far too much.
    InvalidOptionsError
        Options are unknown, of the wrong type, out of range, or given twice.
    """
    for given in in_objects:
        _check_size(given)
    query, errors = _from_query(in_query)
    errors += _given_twice(query, *in_objects)
    checked: dict[str, Any] = {}
    for prefix, given, strict in (("", query, False), *(("options", given, True) for given in in_objects)):
        if not given:
            continue
        try:
            checked |= FitOptions.model_validate(given, strict=strict).model_dump(exclude_unset=True)
        except ValidationError as error:
            errors += option_errors(error, prefix, ALLOWED if prefix else (*ALLOWED, *beside))
    if errors:
        raise InvalidOptionsError(errors)
    return checked


def _check_size(options: Mapping[str, Any]) -> None:
    """Raise `InvalidOptionsError` where an object holds more values than options can have."""
    n_values, inner = 0, [iter(options.values())]
    while inner:
        for value in inner[-1]:
            n_values += 1
            if n_values > _MOST_VALUES:
                message = f"options hold more than {_MOST_VALUES} values, the limit"
                raise InvalidOptionsError([FieldError("options", message)])
            if isinstance(value, dict | list):
                inner.append(iter(value.values() if isinstance(value, dict) else value))
                break
        else:
            inner.pop()


def _from_query(pairs: Sequence[tuple[str, str]]) -> tuple[dict[str, Any], list[FieldError]]:
    """The values by name, and what cannot stand in a query."""
    query: dict[str, Any] = {}
    errors: list[FieldError] = []
    for name, value in pairs:
        if name in LISTS:
            query.setdefault(name, []).extend(value.split(",") if name in COMMAS else [value])
        elif name in OBJECTS:
            errors.append(FieldError(name, "an object does not fit into a query; give it in JSON"))
        elif name in query:
            errors.append(FieldError(name, "given more than once"))
        else:
            query[name] = value
    if query.get("include") == [""]:  # a query has no other way to say that a list is empty
        query["include"] = []
    return query, errors


def _given_twice(*places: Mapping[str, Any]) -> list[FieldError]:
    counts = Counter(name for given in places for name in given)
    return [
        FieldError(f"options.{name}", "given in two places; keep one") for name in counts if counts[name] > 1
    ]


def parse_options(text: bytes | memoryview) -> dict[str, Any]:
    """The JSON text of the part `options`."""
    if len(text) > _TEXT_LIMIT:
        raise UnreadableFileError("options", "options are over 64 KiB long", f"{len(text)} bytes")
    try:
        options = orjson.loads(text)
    except orjson.JSONDecodeError as error:
        raise UnreadableFileError("options", f"not valid JSON at character {error.pos}") from None
    if not isinstance(options, dict):
        raise UnreadableFileError("options", "options must be a JSON object", describe(options))
    return options
