"""The unit of the coordinates of a LAS file, by its coordinate system: GeoTIFF keys or well-known text.

OGC GeoTIFF 1.1 (keys 1024 and 3076, EPSG codes of units) and OGC 01-009 (WKT 1) or 18-010 (WKT 2).
"""

import re
from collections.abc import Mapping

import numpy as np

from primfit.fitting.names import Unit

from .units import METERS

_USER = b"LASF_Projection"
_KEYS, _TEXT = 34735, 2112
_MODEL, _LINEAR = 1024, 3076
_GEOGRAPHIC = 2
_CODES: dict[int, Unit] = {9001: "m", 9002: "ft", 9003: "us-ft"}
_UNIT = re.compile(r'\b(?:LENGTH)?UNIT\s*\[\s*"([^"]*)"\s*,\s*([0-9.]+(?:[eE][+-]?\d+)?)')
_PLANE = re.compile(r"\b(?:PROJCS|PROJCRS|PROJECTEDCRS|GEOCCS|LOCAL_CS|ENGCRS)\s*\[")
_NO_LENGTH = re.compile(r"(?i)deg|rad|grad|gon|arc|unity")
_SAME = 1e-7
"""Relative difference of two lengths of a unit that are one: the two feet differ by 2e-6."""

DEGREES = "By its coordinate system the file is in degrees: distances in it mean nothing; project it first."
OTHER = "The coordinate system of the file has a unit of length that is not known here."


def unit_of(records: Mapping[tuple[bytes, int], memoryview]) -> tuple[Unit | None, str]:
    """The unit that the records of a LAS file tell, and a warning; nothing of either where they tell none."""
    if (_USER, _TEXT) in records:
        return _by_text(bytes(records[_USER, _TEXT]).decode("utf-8", "replace"))
    if (_USER, _KEYS) in records:
        return _by_keys(records[_USER, _KEYS])
    return None, ""


def _by_text(text: str) -> tuple[Unit | None, str]:
    if not text.strip(" \0"):
        return None, ""
    if not _PLANE.search(text):
        return None, DEGREES
    lengths = [float(length) for name, length in _UNIT.findall(text) if not _NO_LENGTH.match(name)]
    if not lengths:
        return None, ""
    # The first one is horizontal; behind it may stand that of the heights.
    same = [unit for unit, length in METERS.items() if abs(lengths[0] / length - 1.0) < _SAME]
    return (same[0], "") if same else (None, OTHER)


def _by_keys(record: memoryview) -> tuple[Unit | None, str]:
    words = np.frombuffer(record[: len(record) // 8 * 8], "<u2").reshape(-1, 4)[1:]
    # A value stands in the key itself where its location is 0.
    keys = {int(key): int(value) for key, location, _, value in words if location == 0}
    if keys.get(_MODEL) == _GEOGRAPHIC:
        return None, DEGREES
    if _LINEAR not in keys:
        return None, ""
    unit = _CODES.get(keys[_LINEAR])
    return unit, "" if unit else OTHER
