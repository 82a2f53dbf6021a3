"""Where a face ends: loops of edges about a rectangle of parameters, or along the rings of an outline."""

from collections.abc import Callable

import numpy as np

from primfit.fitting.geometry.vectors import Array

from ..drawing.patch import Patch
from ..drawing.revolved import Revolved
from .file import File

Edge = tuple[str, bool]
"""Reference to an edge, and whether it is run through in its own direction."""

Curve = Callable[[float], str]
"""Adds the whole curve on which one parameter has this value, and gives the reference to it."""


def bound(file: File, loop: list[Edge], outer: bool = True) -> str:
    edges = [file.add(f"ORIENTED_EDGE('',*,*,{edge},{'.T.' if forth else '.F.'})") for edge, forth in loop]
    boundary = file.add(f"EDGE_LOOP('',({','.join(edges)}))")
    return file.add(f"FACE_{'OUTER_' if outer else ''}BOUND('',{boundary},.T.)")


def outlined(file: File, corners: Array) -> list[Edge]:
    """The straight edges of a ring: counter-clockwise about the normal, or clockwise around a hole."""
    vertices = [file.vertex(corner) for corner in corners]
    following = np.roll(np.arange(len(corners)), -1)
    return [
        (file.edge(vertices[i], vertices[j], file.line(corners[i], corners[j])), True)
        for i, j in enumerate(following)
    ]


def about(file: File, patch: Patch, across: Curve, along: Curve) -> list[list[str]]:
    """The one bound of a piece, counter-clockwise seen from outside: v0 forth, u1 up, v1 back, u0 down.

    Where the piece closes, the two edges along v are one seam, run through both ways; a pole has no edge.

    Parameters
    ----------
    across, along : the curves of constant v, and those of constant u
    """
    (u0, u1), (v0, v1) = patch.u.ends, patch.v.ends
    poles = [v for v, is_pole in zip((v0, v1), patch.poles, strict=True) if is_pole]
    corners: dict[tuple[float, float], str] = {}

    def corner(u: float, v: float) -> str:
        u = u0 if patch.u.closed or v in poles else u
        v = v0 if patch.v.closed else v
        if (u, v) not in corners:
            corners[u, v] = file.vertex(patch.at(u, v))
        return corners[u, v]

    def rim(v: float) -> str | None:
        if v in poles:
            return None
        curve = across(v)
        return file.edge(corner(u0, v), corner(u1, v), curve)

    def side(u: float) -> str:
        return file.edge(corner(u, v0), corner(u, v1), along(u))

    up = side(u0)
    other_up = up if patch.u.closed else side(u1)
    low = rim(v0)
    high = low if patch.v.closed else rim(v1)
    loop = [(low, True), (other_up, True), (high, False), (up, False)]
    return [[bound(file, [(edge, forward) for edge, forward in loop if edge is not None])]]


def about_revolved(file: File, shape: Revolved, meridian: Curve) -> list[list[str]]:
    """The bound of a piece of a surface of revolution, whose curves of constant v are circles."""

    def circle(v: float) -> str:
        rho, height = shape.place(v)
        return file.circle(shape.origin + height * shape.axis, shape.axis, shape.reference, rho)

    return about(file, shape, circle, meridian)


def about_ruled(file: File, shape: Revolved) -> list[list[str]]:
    """The same of one whose meridians are straight."""
    return about_revolved(file, shape, lambda u: file.line(*(shape.at(u, v) for v in shape.v.ends)))
