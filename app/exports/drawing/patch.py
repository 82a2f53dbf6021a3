"""A trimmed surface as a rectangle of two parameters; it need not be one of revolution."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from primfit.fitting.geometry.vectors import Array

FEWEST = 3
"""Strips of a mesh across an arc at least, so that a full turn is a surface."""

STRIPS = 40
"""Pieces of a picture around a full turn."""

BANDS = 6
"""Pieces of a picture along straight lines."""

FINE = 400
"""Samples each way that decide what is hidden."""


@dataclass(frozen=True)
class Span:
    """The range of a parameter.

    Attributes
    ----------
    bend : the radius of the largest arc that an angle runs along, or the longer half axis of an ellipse;
        0 where the lines along which the parameter grows are straight
    closed : it ends where it starts, after a full turn
    """

    start: float
    end: float
    bend: float
    closed: bool = False

    @property
    def ends(self) -> tuple[float, float]:
        return self.start, self.end

    @property
    def middle(self) -> float:
        return (self.start + self.end) / 2.0

    def samples(self, n: int) -> Array:
        """So many values (n,), both ends among them."""
        return np.linspace(self.start, self.end, n)

    def strips(self, largest: float) -> int:
        """Equal parts whose chords keep within a distance of the arc."""
        if self.bend == 0.0:
            return 1
        step = 2.0 * np.arccos(max(1.0 - largest / self.bend, 0.5))
        return max(int(np.ceil((self.end - self.start) / step)), FEWEST)

    def bands(self) -> int:
        """Parts that make the pieces of a picture about square where both ways are curved."""
        wanted = BANDS if self.bend == 0.0 else STRIPS * (self.end - self.start) / (2.0 * np.pi)
        return max(int(np.ceil(wanted)), 4)


@dataclass(frozen=True, eq=False, kw_only=True)
class Patch(ABC):
    """A piece of a surface: points at u and v, counter-clockwise seen from outside.

    Attributes
    ----------
    poles : whether the line at either end of v is one point: a cone's apex, a pole of a sphere
    """

    u: Span
    v: Span
    poles: tuple[bool, bool] = (False, False)

    @abstractmethod
    def at(self, u: Array | float, v: Array | float) -> Array:
        """Points (..., 3) at parameters that broadcast against each other."""

    @abstractmethod
    def axis_line(self) -> Array | None: ...

    @abstractmethod
    def directions(self) -> tuple[Array, Array]: ...

    @property
    def is_closed(self) -> bool:
        return self.u.closed and (self.v.closed or all(self.poles))

    def lattice(self, across: int, along: int) -> Array:
        """So many points each way (along, across, 3)."""
        return self.at(self.u.samples(across), self.v.samples(along)[:, None])

    def mesh(self, chord_error: float) -> tuple[Array, np.ndarray]:
        """Quadrilaterals in two triangles each; rows that close or are a pole share their vertices."""
        size = float(np.linalg.norm(np.ptp(self.lattice(33, 33).reshape(-1, 3), axis=0)))
        across, along = (span.strips(chord_error * size / 2.0) for span in (self.u, self.v))
        number = np.arange((along + 1) * (across + 1)).reshape(along + 1, across + 1)
        if self.u.closed:
            number[:, -1] = number[:, 0]
        if self.v.closed:
            number[-1] = number[0]
        for row, is_pole in zip((0, -1), self.poles, strict=True):
            if is_pole:
                number[row] = number[row, 0]
        a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
        triangles = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
        first, second, third = triangles.T
        triangles = triangles[(first != second) & (second != third) & (third != first)]
        used, renumbered = np.unique(triangles, return_inverse=True)
        return self.lattice(across + 1, along + 1).reshape(-1, 3)[used], renumbered.reshape(-1, 3)

    def pieces(self) -> Array:
        corners = self.lattice(self.u.bands() + 1, self.v.bands() + 1)
        quads = [corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1]]
        return np.stack(quads, axis=2).reshape(-1, 4, 3)

    def edges(self) -> tuple[Array, ...]:
        edges = [self.at(end, self.v.samples(49)) for end in self.u.ends if not self.u.closed]
        ends = zip(self.v.ends, self.poles, strict=True)
        edges += [self.at(self.u.samples(97), end) for end, pole in ends if not (pole or self.v.closed)]
        return tuple(edges)

    def fine(self) -> Array:
        return self.lattice(FINE, FINE).reshape(-1, 3)
