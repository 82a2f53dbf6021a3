"""Units of length as files write them."""

import re
from collections.abc import Sequence

from primfit.fitting.names import Unit

from .errors import UnreadableFileError

METERS: dict[Unit, float] = {
    "um": 1e-6,
    "mm": 1e-3,
    "cm": 1e-2,
    "m": 1.0,
    "km": 1e3,
    "inch": 0.0254,
    "ft": 0.3048,
    "us-ft": 1200.0 / 3937.0,
}
"""How long a unit is; the two feet by NIST, Federal Register 59-5442."""

_SPELT: dict[Unit, str] = {
    "um": "um \u00b5m \u03bcm micron microns micrometer micrometers micrometre micrometres",
    "mm": "mm millimeter millimeters millimetre millimetres",
    "cm": "cm centimeter centimeters centimetre centimetres",
    "m": "m meter meters metre metres",
    "km": "km kilometer kilometers kilometre kilometres",
    "inch": 'in inch inches "',
    "ft": "ft foot feet ift",
    "us-ft": "us-ft usft ft-us ftus us_survey_foot",
}
_UNITS = {name: unit for unit, names in _SPELT.items() for name in names.split()}
_ANGLES = ("deg", "degree", "degrees", "\u00b0", "rad", "gon")
# Units of length, or of pictures, that are known to be in use but not here.
_OTHERS = ("nm", "dm", "yd", "yard", "yards", "mil", "mils", "px", "pixel", "pixels", "nmi", "mi")
_BRACKETED = re.compile(r"[\[(]([^\[\]()]*)[\])]\s*$")


def unit_in(name: str) -> str:
    """What stands in brackets at the end of the name of a column, as in `X [mm]`; empty without."""
    found = _BRACKETED.search(name.strip().strip("\"'"))
    return found[1].strip() if found else ""


def agreed_unit(told: Sequence[str]) -> tuple[Unit | None, tuple[str, ...]]:
    """The unit of coordinates for which these texts stand, and a warning where it is not a known one.

    Raises `UnreadableFileError` where the three differ, or are angles.
    """
    bare = {text.strip().strip("[]()").strip().lower() for text in told} - {"", "-"}
    if bare & set(_ANGLES):
        raise UnreadableFileError("header", "the coordinates are angles; lengths are needed")
    if len(bare) > 1 and bare <= {*_UNITS, *_OTHERS}:
        raise UnreadableFileError("header", "the header gives x, y and z different units; one is needed")
    if bare & set(_OTHERS):
        return None, ("the header gives a unit that is not known here: the answer is in that unit",)
    return _UNITS.get(bare.pop()) if len(bare) == 1 else None, ()
