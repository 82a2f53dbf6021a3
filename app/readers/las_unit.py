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
_MODEL, _LINEAR, _VERTICAL = 1024, 3076, 4099
_GEOGRAPHIC = 2
_CODES: dict[int, Unit] = {9001: "m", 9002: "ft", 9003: "us-ft"}
# A text in quotes, what begins a part of the text, and what ends it.
_TOKEN = re.compile(r'"[^"]*"|(?<![A-Za-z_])([A-Za-z_]++)\s*+[\[(]|[\])]')
_UNIT = re.compile(r'\s*"([^"]*)"\s*,\s*(\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)')
_HEIGHTS = {"VERT_CS", "VERTCRS", "VERTICALCRS"}
# Parts with units of their own, which are not those of the coordinates.
_OTHERS = {"SPHEROID", "ELLIPSOID", "PARAMETER", "PRIMEM", "PRIMEMERIDIAN"}
_PLANE = re.compile(r"\b(?:PROJCS|PROJCRS|PROJECTEDCRS|GEOCCS|LOCAL_CS|ENGCRS)\s*\[")
_NO_LENGTH = re.compile(r"(?i)deg|rad|grad|gon|arc|unity")
_SAME = 1e-7
"""Relative difference of two lengths of a unit that are one: the two feet differ by 2e-6."""

DEGREES = "By its coordinate system the file is in degrees: distances in it mean nothing; project it first."
UNEVEN = "By its coordinate system the file has heights in another unit than the plane: convert one of them."
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
    plane, heights = _lengths(text)
    if not plane:
        return None, ""
    if heights and not _same(plane[0], heights[0]):
        return None, UNEVEN
    found = [unit for unit, length in METERS.items() if _same(plane[0], length)]
    return (found[0], "") if found else (None, OTHER)


def _lengths(text: str) -> tuple[list[float], list[float]]:
    """The units of length of the coordinates in the plane, and those of the heights [m]."""
    plane: list[float] = []
    heights: list[float] = []
    within: list[str] = []
    for token in _TOKEN.finditer(text):
        if token[1]:
            unit = token[1].upper() in ("UNIT", "LENGTHUNIT") and _UNIT.match(text, token.end())
            if unit and not _NO_LENGTH.match(unit[1]) and _OTHERS.isdisjoint(within):
                (plane if _HEIGHTS.isdisjoint(within) else heights).append(float(unit[2]))
            within.append(token[1].upper())
        elif token[0] in ")]" and within:
            within.pop()
    return plane, heights


def _same(length: float, other: float) -> bool:
    return abs(length / other - 1.0) < _SAME if other else False


def _by_keys(record: memoryview) -> tuple[Unit | None, str]:
    words = np.frombuffer(record[: len(record) // 8 * 8], "<u2").reshape(-1, 4)[1:]
    # A value stands in the key itself where its location is 0.
    keys = {int(key): int(value) for key, location, _, value in words if location == 0}
    if keys.get(_MODEL) == _GEOGRAPHIC:
        return None, DEGREES
    if _LINEAR not in keys:
        return None, ""
    unit = _CODES.get(keys[_LINEAR])
    if keys.get(_VERTICAL, keys[_LINEAR]) != keys[_LINEAR]:
        return None, UNEVEN
    return unit, "" if unit else OTHER
