"""The two mistakes a caller can make; everything else is an outcome, not an error."""

from dataclasses import dataclass
from typing import Self


class _FieldError(ValueError):
    """A value from outside that cannot be meant; `field` names it."""

    def __init__(self, message: str, field: str) -> None:
        super().__init__(message)
        self.field = field

    def __reduce__(self) -> tuple[type[Self], tuple[str, str]]:
        return type(self), (str(self), self.field)


class InvalidPointCloudError(_FieldError):
    """The points cannot be a cloud of any allowed kind; the message holds the numbers that say why.

    Examples
    --------
    >>> import primfit
    >>> try:
    ...     primfit.fit([[0, 0, 0], [1, 1, 1], [2, 2, 2]])
    ... except primfit.InvalidPointCloudError as error:
    ...     print(error.field)
    points
    """

    def __init__(self, message: str, field: str = "points") -> None:
        super().__init__(message, field)


class InvalidOptionError(_FieldError):
    """An option is unknown or out of its range; `field` names it.

    Examples
    --------
    >>> import primfit
    >>> try:
    ...     primfit.fit([[0, 0, 0], [1, 0, 0], [0, 1, 0]], max_error=2.0)
    ... except primfit.InvalidOptionError as error:
    ...     print(error.field)
    max_error
    """


@dataclass(frozen=True)
class FailedFit:
    """A fit that cannot be had, as a falsy value with a sentence that says why."""

    reason: str

    def __bool__(self) -> bool:
        return False
