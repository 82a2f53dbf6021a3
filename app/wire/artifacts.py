"""Artefacts as a request asks for them: in the query, apart from the options of the fit."""

from collections.abc import Sequence

from primfit.fitting.errors import InvalidOptionError

from ..exports import FORMATS, ExportOptions, Wanted
from ..exports.options import UNITS
from ..readers.errors import FieldError, describe
from .problems import InvalidOptionsError

NAMES = ("artifacts", "unit", "chord_error")


def split_query(query: Sequence[tuple[str, str]]) -> tuple[list[tuple[str, str]], Wanted]:
    """The options of the fit, and what is to be exported.

    Raises
    ------
    InvalidOptionsError
        No artefact is named, one or a unit is unknown, or a value is out of range or given twice.
    """
    rest = [(name, value) for name, value in query if name not in NAMES]
    given: dict[str, list[str]] = {}
    for name, value in query:
        if name in NAMES:
            given.setdefault(name, []).append(value)
    formats = [format for value in given.pop("artifacts", []) for format in value.split(",")]
    errors = [
        FieldError(f"artifacts[{i}]", f"unknown artefact; allowed are {', '.join(FORMATS)}", describe(format))
        for i, format in enumerate(formats)
        if format not in FORMATS
    ]
    if not formats:
        errors.append(FieldError("artifacts", f"is missing; name some of {', '.join(FORMATS)}"))
    errors += [FieldError(name, "given more than once") for name, values in given.items() if len(values) > 1]
    if errors:
        raise InvalidOptionsError(errors)
    return rest, Wanted(tuple(dict.fromkeys(formats)), _options({n: v[0] for n, v in given.items()}))


def _options(given: dict[str, str]) -> ExportOptions:
    unit, told = given.get("unit", ExportOptions.unit), given.get("chord_error", ExportOptions.chord_error)
    if unit not in UNITS:
        message = f"unknown unit; allowed are {', '.join(UNITS)}"
        raise InvalidOptionsError([FieldError("unit", message, describe(unit))])
    try:
        chord_error = float(told)
    except ValueError:
        raise InvalidOptionsError([FieldError("chord_error", "not a number", describe(told))]) from None
    try:
        return ExportOptions(unit, chord_error)  # type: ignore[arg-type]
    except InvalidOptionError as error:
        raise InvalidOptionsError([FieldError(error.field, str(error))]) from None
