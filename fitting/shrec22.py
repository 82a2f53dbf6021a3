"""Primitives as the column vectors of the SHREC 2022 track: a label, then the parameters in its order.

Source: Romanengo et al., "SHREC 2022: Fitting and recognition of simple geometric primitives on point
clouds", Computers & Graphics 107, 2022, section 2.1. A torus has its major radius first.
"""

from collections.abc import Sequence

import numpy as np

from .primitives import PRIMITIVES
from .primitives.primitive import Primitive

LAYOUT: dict[str, tuple[int, tuple[str, ...]]] = {
    "plane": (1, ("normal", "point")),
    "cylinder": (2, ("radius", "axis", "point")),
    "sphere": (3, ("radius", "center")),
    "cone": (4, ("half_angle", "axis", "apex")),
    "torus": (5, ("major_radius", "minor_radius", "axis", "center")),
}
"""Kind -> label and the names of its parameters in the track's order."""

_KINDS = {label: kind for kind, (label, _) in LAYOUT.items()}


def to_vector(primitive: Primitive) -> tuple[int, list[float]]:
    """The label and the parameters, in the track's order."""
    label, names = LAYOUT[primitive.kind]
    return label, [float(number) for name in names for number in np.atleast_1d(getattr(primitive, name))]


def from_vector(label: int, numbers: Sequence[float]) -> Primitive:
    """The primitive of a label and its parameters; raises `ValueError` where they do not go together."""
    if label not in _KINDS:
        raise ValueError(f"the label is {label}; the track's are {', '.join(map(str, _KINDS))}")
    kind = _KINDS[label]
    names = LAYOUT[kind][1]
    sizes = [1 if "radius" in name or "angle" in name else 3 for name in names]
    if len(numbers) != sum(sizes):
        raise ValueError(f"a {kind} has {sum(sizes)} parameters, not {len(numbers)}")
    parts = np.split(np.asarray(numbers, np.float64), np.cumsum(sizes)[:-1])
    values = {
        name: part if len(part) == 3 else float(part[0]) for name, part in zip(names, parts, strict=True)
    }
    return PRIMITIVES[kind](**values)
