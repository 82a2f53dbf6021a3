"""How each kind is drawn: one file a kind, found by its name, and the contract that they share.

A file of a kind says how its surface is trimmed, how residuals are laid out flat, and in which words.
"""

from importlib import import_module
from typing import Any, Protocol, cast

import numpy as np

from primfit.fitting.extents.values import Extents
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.names import KINDS
from primfit.fitting.primitives.primitive import Primitive

from .unrolled import Unrolled

Mesh = tuple[Array, np.ndarray]
"""Vertices (K, 3) and triangles (M, 3), counter-clockwise seen from outside."""


class Shape(Protocol):
    """A trimmed surface, as meshes and the views of a report ask for it: see `patch` and `flat`."""

    @property
    def is_closed(self) -> bool:
        """Whether it has no edge."""
        ...

    def mesh(self, chord_error: float) -> Mesh:
        """Triangles that keep within so large a share of its size from it."""
        ...

    def pieces(self) -> Array:
        """Corners (M, 4, 3) of small quadrilaterals, or (M, 3, 3) of triangles."""
        ...

    def edges(self) -> tuple[Array, ...]:
        """Polylines (K, 3) where it ends."""
        ...

    def fine(self) -> Array:
        """Samples (S, 3), dense enough to hide what is behind; none where it hides nothing of note."""
        ...

    def axis_line(self) -> Array | None:
        """Ends (2, 3) of its axis, a little longer than it is; None where it has none."""
        ...

    def directions(self) -> tuple[Array, Array]:
        """Which way (3,) is up in the pictures, and which is to the viewer."""
        ...


class Drawing(Protocol):
    """What the file of a kind holds.

    Attributes
    ----------
    POSITIVE : where signed distances are positive, in words
    UPRIGHT : what of it is upright in the views
    """

    POSITIVE: str
    UPRIGHT: str

    def trimmed(self, primitive: Any, extents: Any) -> Shape:
        """The primitive of this kind within its extents."""
        ...

    def unrolled(self, primitive: Any, shape: Any, points: Array) -> Unrolled:
        """Points (N, 3) near the primitive on the plane of a map; `shape` is what `trimmed` made."""
        ...


DRAWINGS: dict[str, Drawing] = {kind: cast(Drawing, import_module(f".{kind}", __name__)) for kind in KINDS}


def shape_of(primitive: Primitive, extents: Extents) -> Shape:
    """The primitive within its extents."""
    return DRAWINGS[primitive.kind].trimmed(primitive, extents)
