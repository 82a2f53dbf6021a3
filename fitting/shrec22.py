"""Primitives as the column vectors of the SHREC 2022 track: a label, then the parameters in its order.

And distances as the track measures them.

Source: Romanengo et al., "SHREC 2022: Fitting and recognition of simple geometric primitives on point
clouds", Computers & Graphics 107, 2022, section 2. A torus has its major radius first.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from .geometry.vectors import Array, basis
from .primitives import PRIMITIVES
from .primitives.cone import Cone
from .primitives.cylinder import Cylinder
from .primitives.plane import Plane
from .primitives.primitive import Primitive
from .primitives.torus import Torus

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


def sampled_distances(primitive: Primitive, points: Array, grid: int) -> Array:
    """Distances (N,) of points to the closest of `grid` x `grid` samples of the surface, as in the paper.

    Samples lie on a regular grid of the parameters of `Primitive.surface`: full turns, and as far as the
    points reach in the parameters that are lengths. They overestimate by up to half a cell's diagonal.
    """
    from scipy.spatial import cKDTree  # takes longer to import than all else here

    samples = primitive.surface(*np.meshgrid(*_spans(primitive, points, grid))).reshape(-1, 3)
    if not np.isfinite(samples).all():
        return np.full(len(points), np.inf)
    return np.asarray(cKDTree(samples).query(points)[0])


def _spans(primitive: Primitive, points: Array, grid: int) -> Iterator[Array]:
    turn = np.linspace(0.0, 2.0 * np.pi, grid)
    match primitive:
        case Plane():
            for direction in basis(primitive.normal):
                lengths = (points - primitive.point) @ direction
                yield np.linspace(lengths.min(), lengths.max(), grid)
            return
        case Cylinder():
            heights = (points - primitive.point) @ primitive.axis
        case Cone():
            heights = np.maximum((points - primitive.apex) @ primitive.axis, 0.0)
        case Torus():
            heights = turn
        case _:
            heights = turn / 2
    yield turn
    yield np.linspace(heights.min(), heights.max(), grid)
