"""What can be wrong with the bytes of a cloud; no message ever repeats the input."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from primfit.fitting.errors import InvalidPointCloudError

SHOWN = 20


@dataclass(frozen=True)
class FieldError:
    """One bad field: its name (`points[17][2]`, `line 4`), what is wrong, the class of the value found."""

    field: str
    message: str
    value: str | None = None


class UnreadableFileError(ValueError):
    """The bytes are not a cloud; `field` and `message` say where and why, `errors` lists more.

    With `no_cloud` they are not meant for one: a table of something else, a text without numbers, nothing.

    Examples
    --------
    >>> import pathlib, tempfile, primfit
    >>> file = pathlib.Path(tempfile.mkdtemp(), "scan.csv")
    >>> _ = file.write_text("1,2\\n3,4\\n")
    >>> try:
    ...     primfit.read(file)
    ... except primfit.UnreadableFileError as error:
    ...     print(f"{error.field}: {error}")
    file: rows hold 2 values; a point needs x, y and z
    """

    def __init__(
        self,
        field: str,
        message: str,
        value: str | None = None,
        errors: Sequence[FieldError] = (),
        *,
        no_cloud: bool = False,
    ) -> None:
        super().__init__(message)
        self.field = field
        self.message = message
        self.no_cloud = no_cloud
        self.errors = tuple(errors)[:SHOWN] or (FieldError(field, message, value),)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.field, self.message, None, self.errors)


class InvalidPointsError(UnreadableFileError, InvalidPointCloudError):
    """The file is readable, but what it holds are not finite points (N, 3)."""


class TooLargeError(UnreadableFileError):
    """The input is over a limit; the message names the limit."""


def describe(value: object) -> str:
    """The class of a parsed value, in words and without its content."""
    match value:
        case None:
            return "null"
        case bool():
            return "boolean"
        case str():
            return f"string of {len(value)} characters"
        case list():
            return f"array of {len(value)}"
        case dict():
            return "object"
        case _:
            return "number"
