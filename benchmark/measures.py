"""How far an answer is from the truth."""

import numpy as np

from fitting.geometry import Array
from fitting.primitives import Primitive
from fitting.primitives.shrec22 import to_vector
from fitting.result import Recognition

DIRECTIONS = {"plane": slice(0, 3), "cylinder": slice(1, 4), "cone": slice(1, 4), "torus": slice(2, 5)}
"""Where the direction stands in the track's vectors; its sign is free but for the cone's apex side."""

COMPARED = {"plane": 3, "cylinder": 4}
"""How many leading parameters are compared: the point of a plane or a cylinder is not unique."""


def is_right(answer: Recognition, truth: Primitive) -> bool:
    """Whether the kind is the true one; `ambiguous` and `no_fit` count as wrong."""
    return answer.status == "fitted" and answer.primitive is not None and answer.primitive.kind == truth.kind


def l2(found: Primitive, truth: Primitive) -> float:
    """The track's L2 distance between parameter vectors of one kind.

    Minimised over the sign of the axis, with a torus's radii sorted; the points of planes and cylinders
    are left out. Source: Romanengo et al. 2022, section 2.2.2.
    """
    a, b = (_compared(primitive) for primitive in (found, truth))
    opposite = a.copy()
    if found.kind in DIRECTIONS:
        opposite[DIRECTIONS[found.kind]] *= -1.0
    return float(min(np.linalg.norm(a - b), np.linalg.norm(opposite - b)))


def _compared(primitive: Primitive) -> Array:
    vector = np.array(to_vector(primitive)[1])
    if primitive.kind == "torus":
        vector[:2] = np.sort(vector[:2])
    return vector[: COMPARED.get(primitive.kind)]
