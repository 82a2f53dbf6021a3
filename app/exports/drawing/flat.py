"""Pieces of a plane with holes."""

from dataclasses import dataclass

import numpy as np

from primfit.fitting.geometry.vectors import Array, basis


@dataclass(frozen=True, eq=False)
class Flat:
    """Pieces of a plane.

    Attributes
    ----------
    rings : of each piece the outer ring (K, 3), counter-clockwise about the normal, then those of its holes
    normal : (3,)
    center, long, short : (3,) of the rectangle about them, and the directions of its sides
    """

    rings: tuple[tuple[Array, ...], ...]
    normal: Array
    center: Array
    long: Array
    short: Array

    is_closed = False

    def mesh(self, chord_error: float) -> tuple[Array, np.ndarray]:
        """Constrained Delaunay triangles between the corners of the rings, which stay as they are."""
        import shapely
        from scipy.spatial import cKDTree

        corners = np.concatenate([ring for rings in self.rings for ring in rings])
        # Of size 1, so that no area overflows.
        frame = np.array(basis(self.normal)) / np.ptp(corners, axis=0).max()

        def seen(ring: Array) -> Array:
            return (ring - corners[0]) @ frame.T

        shape = shapely.MultiPolygon(
            [(seen(outer), [seen(hole) for hole in holes]) for outer, *holes in self.rings]
        )
        parts = shapely.get_parts(shapely.constrained_delaunay_triangles(shape))
        triangles = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
        number = cKDTree(seen(corners)).query(triangles)[1]
        first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
        clockwise = first[:, 0] * second[:, 1] < first[:, 1] * second[:, 0]
        number[clockwise] = number[clockwise][:, ::-1]
        return corners, number

    def pieces(self) -> Array:
        corners, triangles = self.mesh(0.0)
        return corners[triangles]

    def edges(self) -> tuple[Array, ...]:
        return tuple(np.vstack([ring, ring[:1]]) for rings in self.rings for ring in rings)

    def fine(self) -> Array:
        return np.empty((0, 3))

    def axis_line(self) -> None:
        return None

    def directions(self) -> tuple[Array, Array]:
        return self.normal, -self.short
