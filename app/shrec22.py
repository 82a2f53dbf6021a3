"""Predictions in the text format of the SHREC 2022 track: the label, then the parameters, one number a line.

Romanengo et al., "SHREC 2022: Fitting and recognition of simple geometric primitives on point clouds",
Computers & Graphics 107, 2022. A torus has its major radius first, as in the files of the track.
"""

from collections.abc import Mapping
from typing import Any

# kind -> label and the order of its parameters
LAYOUT: dict[str, tuple[int, tuple[str, ...]]] = {
    "plane": (1, ("normal", "point")),
    "cylinder": (2, ("radius", "axis", "point")),
    "sphere": (3, ("radius", "center")),
    "cone": (4, ("half_angle", "axis", "apex")),
    "torus": (5, ("major_radius", "minor_radius", "axis", "center")),
}


def prediction(primitive: Mapping[str, Any]) -> str:
    """The text of NAME_prediction.txt.

    Parameters
    ----------
    primitive : `kind` and parameters as in the answer (`fitting.primitives.parameters`)

    Returns
    -------
    One number a line; each reads back as the same float64.
    """
    label, names = LAYOUT[primitive["kind"]]
    numbers: list[float] = []
    for name in names:
        value = primitive[name]
        numbers += value if isinstance(value, list) else [value]
    return "".join(f"{number!r}\n" for number in (label, *numbers))
