"""Artifacts as a request asks for them: in the query, apart from the options of the fit."""

from collections import Counter
from collections.abc import Sequence

from primfit.fitting.errors import InvalidOptionError

from ..exports import FORMATS, ExportOptions, Wanted
from ..exports.options import ABOUT
from ..readers.errors import FieldError, describe
from .problems import InvalidOptionsError

NAMES = ("artifacts", "chord_error", "export_kind", *ABOUT)


def split_query(query: Sequence[tuple[str, str]]) -> tuple[list[tuple[str, str]], Wanted]:
    """The options of the fit, and what is to be exported.

    Raises
    ------
    InvalidOptionsError
        No artifact is named, one or a unit is unknown, or a value is out of range or given twice.
    """
    rest = [(name, value) for name, value in query if name not in NAMES]
    formats = [format for name, value in query if name == "artifacts" for format in value.split(",")]
    beside = [(name, value) for name, value in query if name in NAMES[1:]]
    errors = [*_wrong_formats(formats), *_repeated(beside)]
    if errors:
        raise InvalidOptionsError(errors)
    return rest, Wanted(tuple(dict.fromkeys(formats)), _options(dict(beside)))


def _wrong_formats(formats: list[str]) -> list[FieldError]:
    errors = [
        FieldError(f"artifacts[{i}]", f"unknown artifact; allowed are {', '.join(FORMATS)}", describe(format))
        for i, format in enumerate(formats)
        if format not in FORMATS
    ]
    if not formats:
        errors.append(FieldError("artifacts", f"is missing; name some of {', '.join(FORMATS)}"))
    return errors


def _repeated(given: list[tuple[str, str]]) -> list[FieldError]:
    counts = Counter(name for name, _ in given)
    return [FieldError(name, "given more than once") for name in counts if counts[name] > 1]


def _options(given: dict[str, str]) -> ExportOptions:
    told = given.get("chord_error", ExportOptions.chord_error)
    try:
        chord_error = float(told)
    except ValueError:
        raise InvalidOptionsError([FieldError("chord_error", "not a number", describe(told))]) from None
    try:
        beside = {name: given.get(name) for name in NAMES[2:]}
        return ExportOptions(chord_error=chord_error, **beside)  # type: ignore[arg-type]
    except InvalidOptionError as error:
        raise InvalidOptionsError([FieldError(error.field, str(error))]) from None
