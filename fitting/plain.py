"""Results as JSON has them."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

_PLAIN = frozenset((bool, float, int, str, type(None)))


def plain(value: Any) -> Any:
    """Records and mappings as dicts, arrays and tuples as lists, and numbers of NumPy as those of Python."""
    if type(value) in _PLAIN:  # most are, and other questions take longer
        return value
    if isinstance(value, tuple | list):
        return [plain(each) for each in value]
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {name: plain(each) for name, each in value.items()}
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    return value


def worded(name: str) -> str:
    """A name of the answer in words: `major_radius`, `half_angle`, `axis.x`, `no_fit`."""
    return name.replace("half_angle", "half-angle").replace("_", " ").replace(".", " ")
