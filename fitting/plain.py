"""Results as JSON has them."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

_PLAIN = frozenset((bool, float, int, str, type(None)))
_NAMES: dict[type, tuple[str, ...]] = {}


def plain(value: Any) -> Any:
    """Records and mappings as dicts, arrays and tuples as lists, and numbers of NumPy as those of Python."""
    of = type(value)
    if of in _PLAIN:  # most are, and other questions take longer
        return value
    if names := field_names(of):
        return {name: plain(getattr(value, name)) for name in names}
    if isinstance(value, tuple | list):
        return [plain(each) for each in value]
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {name: plain(each) for name, each in value.items()}
    return value


def field_names(of: type) -> tuple[str, ...]:
    """The fields of a class of records, in their order; none of another class."""
    if (names := _NAMES.get(of)) is None:
        names = _NAMES[of] = tuple(field.name for field in fields(of)) if is_dataclass(of) else ()
    return names


def worded(name: str) -> str:
    """A name of the answer in words: `major_radius`, `half_angle`, `axis.x`, `no_fit`."""
    return name.replace("half_angle", "half-angle").replace("_", " ").replace(".", " ")
