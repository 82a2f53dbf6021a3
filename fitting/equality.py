"""Records that hold arrays: equal where all that is in them is equal, also after they were pickled."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from .plain import field_names


def equal(one: Any, other: Any) -> bool:
    """Whether two values are equal; arrays by their shapes and numbers, of which NaN equals NaN."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return type(one) is type(other) and _same_numbers(one, other)
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(equal, one, other))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(equal(one[name], other[name]) for name in one)
    return bool(one == other or (one != one and other != other))


def _same_numbers(one: np.ndarray, other: np.ndarray) -> bool:
    return one.shape == other.shape and bool(((one == other) | ((one != one) & (other != other))).all())


def hash_of(value: Any) -> int:
    """The same for values that are `equal`."""
    if isinstance(value, np.ndarray):
        return hash(tuple(value.ravel().tolist()))
    if isinstance(value, tuple):
        return hash(tuple(map(hash_of, value)))
    if isinstance(value, Mapping):
        return hash(frozenset((name, hash_of(each)) for name, each in value.items()))
    return hash(value)


def equal_records(one: object, other: object) -> bool:
    """Whether two records are of one class and all their fields are equal."""
    return type(one) is type(other) and equal(_fields(one), _fields(other))


def hash_of_record(record: object) -> int:
    """The same for `equal_records`."""
    return hash_of(_fields(record))


def _fields(record: object) -> tuple[Any, ...]:
    return tuple(getattr(record, name) for name in field_names(type(record)))


class ByValue:
    """Gives `equal_records` to a dataclass that makes no comparison of its own (`eq=False`)."""

    def __eq__(self, other: object) -> bool:
        return equal_records(self, other)

    def __hash__(self) -> int:
        return hash_of_record(self)
