"""The contract that the primitives share, and their table: one file each, of the name of its kind."""

from dataclasses import fields
from importlib import import_module
from typing import ClassVar, Protocol, Self

import numpy as np

from ..geometry.vectors import Array
from ..names import KINDS


class Primitive(Protocol):
    """A frozen surface. Points are (N, 3); lengths carry the unit of the points, angles are radians."""

    kind: ClassVar[str]
    dof: ClassVar[int]

    def signed_distance(self, points: Array) -> Array:
        """Signed orthogonal distances, shape (N,), positive on the outer side."""
        ...

    def gradient(self, points: Array) -> Array:
        """Unit gradients (N, 3) of the signed distance: x - d * gradient is the closest surface point."""
        ...

    def row(self) -> Array:
        """The nine numbers that the compiled search steps in; see `fitting.solver._descent`."""
        ...

    @classmethod
    def from_row(cls, row: Array) -> Self:
        """The surface of such a row."""
        ...

    def transformed(self, rotation: Array, translation: Array, scale: float) -> Self:
        """The surface carried along by  x -> scale * rotation @ x + translation."""
        ...

    @classmethod
    def initial_guesses(cls, points: Array, normals: Array, rng: np.random.Generator) -> Array:
        """Closed-form starts, as rows (K, 9), from a sample (N, 3) with unit normals (N, 3).

        The sample is in the normalised frame.
        Normals help, but poor ones do no harm: starts that need none are always among them.
        """
        ...

    def canonical(self, center: Array) -> Self:
        """The same surface in its one sign and order; free points are those closest to `center`."""
        ...

    def simpler_kinds(self, extent: float) -> tuple[str, ...]:
        """Simpler kinds that this surface nearly is, over a cloud whose rms radius is `extent`."""
        ...

    def surface(self, u: Array, v: Array) -> Array:
        """Points of the surface, shape (..., 3), at parameters that broadcast against each other."""
        ...


PRIMITIVES: dict[str, type[Primitive]] = {
    kind: getattr(import_module(f".{kind}", __name__), kind.capitalize()) for kind in KINDS
}


def parameters(primitive: Primitive) -> dict[str, str | float | list[float]]:
    """The public parameters as plain values, `kind` first."""
    values: dict[str, str | float | list[float]] = {"kind": primitive.kind}
    for field in fields(primitive):  # type: ignore[arg-type]
        value = getattr(primitive, field.name)
        values[field.name] = value if isinstance(value, float) else value.tolist()
    return values
