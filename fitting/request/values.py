"""Plain values from outside as numbers and vectors, with the field and the limit in every complaint."""

from collections.abc import Iterable, Mapping

import numpy as np

from ..errors import InvalidOptionError
from ..words import as_given

LARGEST = 1e100
"""Beyond this magnitude squares and products of lengths overflow, as those of coordinates do."""

Triple = tuple[float, float, float]


def number(field: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise InvalidOptionError(f"{field} is {value!r:.40}, not a number", field)
    return float(value)


def positive(field: str, value: object) -> float:
    result = number(field, value)
    if not 0.0 < result <= LARGEST:
        raise InvalidOptionError(
            f"{field} is {as_given(result)}; it must be positive and at most {LARGEST:.0e}", field
        )
    return result


def triple(field: str, value: object) -> Triple:
    if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable):
        raise InvalidOptionError(f"{field} is {value!r:.40}; [x, y, z] is needed", field)
    numbers = [number(field, each) for each in value]
    if len(numbers) != 3:
        raise InvalidOptionError(f"{field} has {len(numbers)} numbers; [x, y, z] is needed", field)
    for each in numbers:
        if not abs(each) <= LARGEST:
            raise InvalidOptionError(
                f"{field} holds {as_given(each)}; finite numbers up to {LARGEST:.0e} are allowed", field
            )
    return (numbers[0], numbers[1], numbers[2])


def direction(field: str, value: object) -> Triple:
    result = triple(field, value)
    if not any(result):
        raise InvalidOptionError(f"{field} is zero; a direction needs a length", field)
    return result
