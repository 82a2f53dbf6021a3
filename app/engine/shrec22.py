"""Predictions in the text format of the SHREC 2022 track: the label, then the parameters, one number a line.

Made from the answer, not from the primitive: the numbers are the same to the last digit.
"""

from collections.abc import Mapping
from typing import Any

from primfit.fitting.shrec22 import LAYOUT


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
