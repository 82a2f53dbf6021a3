"""The plane: a unit normal and a point.

Signed distance, with the normal n and the point p:  d(x) = n . (x - p).
"""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ..geometry.vectors import Array, basis, canonical_direction, cross, principal, rows, unit, vector
from ..guesses.oriented import Oriented, random_subsets
from .primitive import NO_ROWS, Chart, Known, Limited, Primitive

RANDOM_PLANES = 24


@dataclass(frozen=True, eq=False)
class Plane(Primitive):
    """A plane; signed distances are positive on the side that the normal points to.

    Attributes
    ----------
    normal : (3,) unit vector
    point : (3,) on the plane; in an answer the one closest to the centroid of the cloud

    Examples
    --------
    >>> import numpy as np, primfit
    >>> plane = primfit.Plane(normal=[0, 0, 1], point=[0, 0, 5])
    >>> plane.signed_distance(np.array([[1.0, 2.0, 7.0], [3.0, 4.0, 4.5]]))
    array([ 2. , -0.5])
    """

    normal: Array
    point: Array

    kind: ClassVar[str] = "plane"
    dof: ClassVar[int] = 3
    chart: ClassVar[Chart] = Chart(tilts=(0, 1), shifts=(2,), across=((0, 1),), numbers={})
    form: ClassVar[str] = "flatness"
    quadrics: ClassVar[int] = 4
    flat: ClassVar[bool] = True
    has_sign: ClassVar[bool] = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "normal", unit(self.normal))
        object.__setattr__(self, "point", vector(self.point))

    def signed_distance(self, points: Array) -> Array:
        return (points - self.point) @ self.normal

    def gradient(self, points: Array) -> Array:
        return np.broadcast_to(self.normal, points.shape)

    def row(self) -> Array:
        return rows(self.normal, self.point)

    @classmethod
    def from_row(cls, row: Array) -> Self:
        return cls(row[:3], row[3:6])

    def transformed(self, rotation: Array, translation: Array, scale: float) -> Self:
        return type(self)(rotation @ self.normal, scale * (rotation @ self.point) + translation)

    @classmethod
    def initial_guesses(cls, oriented: Oriented, rng: np.random.Generator) -> Array:
        """The principal plane, and planes through three random points."""
        points = oriented.points
        center = points.mean(axis=0)
        _, vectors = np.linalg.eigh((points - center).T @ (points - center))
        corners = points[random_subsets(len(points), 3, RANDOM_PLANES, rng)]
        across = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(across, axis=1)
        wide = length > 1e-9
        directions = np.vstack([vectors[:, 0], across[wide] / length[wide, None]])
        return rows(directions, np.vstack([center, corners[wide, 0]]))

    @staticmethod
    def impose(row: Array, points: Array, limits: Limited) -> None:
        """Bring a row (9,) within limits, as near to the points (N, 3) as a linear step brings it."""
        if not limits.pinned:
            row[3:6] = np.median(points @ row[:3]) * row[:3]

    def bends(self, feet: Array) -> list[tuple[tuple[str, ...], Array]]:
        """Wide surfaces of all other kinds leave it by a quadratic."""
        x, y = np.array(basis(self.normal)) @ (feet - feet.mean(axis=0)).T
        return [(("sphere", "cylinder", "cone", "torus"), np.stack([x * x, x * y, y * y], axis=1))]

    def coordinates(self, feet: Array, extent: float) -> list[tuple[Array, float]]:
        axes = principal(feet)[1]
        return [(feet @ axes[:, 0] / extent, 0.0), (feet @ axes[:, 1] / extent, 0.0)]

    @classmethod
    def guesses_given(cls, known: Known, oriented: Oriented, rng: np.random.Generator) -> Array:
        if known.direction is None:
            return NO_ROWS
        return rows(known.direction, np.median(oriented.points, axis=0))[None]

    def canonical(self, center: Array) -> Self:
        """Same plane, normal in its canonical sign, point closest to `center`."""
        return type(self)(
            canonical_direction(self.normal), center - self.signed_distance(center) * self.normal
        )

    def simpler_kinds(self, extent: float) -> tuple[str, ...]:
        return ()

    def surface(self, u: Array, v: Array) -> Array:
        """Points at lengths `u`, `v` along two directions in the plane, from `point`."""
        along_u, along_v = basis(self.normal)
        return self.point + np.multiply.outer(u, along_u) + np.multiply.outer(v, along_v)
