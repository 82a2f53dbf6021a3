"""The contract that the primitives share, each of which stands in a file of the name of its kind."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple, Protocol, Self

import numpy as np

from ..equality import equal_records, hash_of_record
from ..geometry.vectors import Array
from ..guesses.oriented import Oriented

NO_ROWS: Array = np.empty((0, 9))


class Number(NamedTuple):
    """Where a number of a kind is: which component of a step adds to it, and its place in a row."""

    component: int
    place: int


@dataclass(frozen=True)
class Chart:
    """What the components of a step do; `geometry/surface.h` says in which order they are.

    Attributes
    ----------
    tilts : those that turn the axis or normal
    shifts : those that move the position
    across : pairs of them along the two directions of `basis(axis)`, which turn with that
    numbers : radii and angles, by name
    """

    tilts: tuple[int, ...]
    shifts: tuple[int, ...]
    across: tuple[tuple[int, int], ...]
    numbers: Mapping[str, Number] = field(default_factory=dict)


class Limited(Protocol):
    """What a kind asks of limits to bring a row within them; see `fitting.trial.limits.Limits`."""

    @property
    def pinned(self) -> bool:
        """Whether the position is fixed: at the origin."""
        ...

    @property
    def reference(self) -> Array | None:
        """The unit direction (3,) that the axis is constrained by; it is within its limit already."""
        ...

    def clip(self, row: Array, place: int) -> float:
        """Bring the number at this place of a row into its bounds; by how much it grew."""
        ...


@dataclass(frozen=True, eq=False)
class Known:
    """A direction (3,) of the axis or normal and a position (3,) that a caller has given, or None."""

    direction: Array | None
    position: Array | None


class Primitive(Protocol):
    """A frozen surface. Points are (N, 3); lengths carry the unit of the points, angles are radians.

    Attributes
    ----------
    dof : parameters that determine it
    chart : what the components of a step do
    form : name of its form error
    quadrics : how many quadrics, linearly independent, hold all of it
    flat : it is a plane
    has_sign : its axis may point one way only

    Examples
    --------
    >>> import primfit
    >>> def size(primitive: primfit.Primitive) -> float:
    ...     return getattr(primitive, "radius", 0.0)
    >>> size(primfit.Sphere([0, 0, 0], 2.0))
    2.0
    """

    kind: ClassVar[str]
    dof: ClassVar[int]
    chart: ClassVar[Chart]
    form: ClassVar[str]
    quadrics: ClassVar[int] = 1
    flat: ClassVar[bool] = False
    has_sign: ClassVar[bool] = True

    def __eq__(self, other: object) -> bool:
        return equal_records(self, other)

    def __hash__(self) -> int:
        return hash_of_record(self)

    def signed_distance(self, points: Array) -> Array:
        """Signed orthogonal distances, shape (N,), positive on the outer side."""
        ...

    def gradient(self, points: Array) -> Array:
        """Unit gradients (N, 3) of the signed distance: x - d * gradient is the closest surface point."""
        ...

    def row(self) -> Array:
        """The nine numbers that the compiled loops step in; see `geometry/surface.h`."""
        ...

    @classmethod
    def from_row(cls, row: Array) -> Self:
        """The surface of such a row."""
        ...

    def transformed(self, rotation: Array, translation: Array, scale: float) -> Self:
        """The surface carried along by  x -> scale * rotation @ x + translation."""
        ...

    def canonical(self, center: Array) -> Self:
        """The same surface in its one sign and order; free points are those closest to `center`."""
        ...

    def surface(self, u: Array, v: Array) -> Array:
        """Points of the surface, shape (..., 3), at parameters that broadcast against each other."""
        ...

    # -- starts ---------------------------------------------------------------------------------------------

    @classmethod
    def initial_guesses(cls, oriented: Oriented, rng: np.random.Generator) -> Array:
        """Closed-form starts, as rows (K, 9), from a sample in the normalized frame.

        Normals help, but poor ones do no harm: starts that need none are always among them.
        """
        ...

    @classmethod
    def later_guesses(
        cls, oriented: Oriented, rng: np.random.Generator, settled: Callable[[str, Array], Array]
    ) -> Array:
        """More of them, from those of another kind after some robust steps: `settled(kind, rows)`."""
        return NO_ROWS

    @classmethod
    def guesses_given(cls, known: Known, oriented: Oriented, rng: np.random.Generator) -> Array:
        """More of them where something is known."""
        return NO_ROWS

    # -- steps and limits -----------------------------------------------------------------------------------

    @staticmethod
    def impose(row: Array, points: Array, limits: Limited) -> None:
        """Bring a row (9,) within limits, as near to the points (N, 3) as a linear step brings it."""
        ...

    def bent_row(self, step: Array) -> Array | None:
        """The row after a step (dof,) along which curvatures change linearly; see `geometry.turning`.

        To first order it is that of `stepped`. None where that cannot be said: the origin is not near the
        surface, or it has no curvature.
        """
        return None

    # -- neighbors, noise and evidence ---------------------------------------------------------------------

    def simpler_kinds(self, extent: float) -> tuple[str, ...]:
        """Simpler kinds that this surface nearly is, over a cloud whose rms radius is `extent`."""
        ...

    def bends(self, feet: Array) -> list[tuple[tuple[str, ...], Array]]:
        """Kinds that have this one for a limit, and by what distances change, (P, k), where they leave it.

        To first order, at feet (P, 3); in any unit each.
        """
        return []

    def coordinates(self, feet: Array, extent: float) -> list[tuple[Array, float]]:
        """Coordinates (N,) of points on it, angles [rad] or lengths over the extent; their period or 0."""
        return []

    def most_curved(self, feet: Array) -> tuple[Array, float] | None:
        """Beside its sizes, a sum of its numbers, by weights (P,), that follows a step by a curve.

        With the length that tells how strongly: where what is uncertain of the sum is no small share of that,
        linearized intervals are off. `feet` (N, 3) are the points on it.
        """
        return None
