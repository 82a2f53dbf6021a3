"""The constraints on one kind as the compiled steps obey them, and starts that obey them too.

A fixed centre, apex or point becomes the origin of the frame: the foot of the origin on an axis is then that
point itself, tilts turn about it, and fixing it means not to shift.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ..cloud.frame import Frame
from ..geometry.axes import Seen, random_subsets, revolution_axis
from ..geometry.vectors import TINY, Z_AXIS, Array, around_axis, basis, cross, foot_of_origin, rows, unit
from ..primitives import PRIMITIVES, Primitive
from ..primitives.cone import Cone
from ..primitives.cylinder import Cylinder
from ..primitives.torus import Torus
from ..request.constraints import Constraints, Direction, Range
from ._limits import Bounds

MOST_COORDINATES = 7

TILTS: dict[str, tuple[int, ...]] = {"plane": (0, 1), "cylinder": (0, 1), "cone": (0, 1), "torus": (0, 1)}
SHIFTS: dict[str, tuple[int, ...]] = {
    "plane": (2,),
    "sphere": (0, 1, 2),
    "cylinder": (2, 3),
    "cone": (2, 3, 5),
    "torus": (2, 3, 4),
}
"""Components of a step (`fitting.solver._descent`) that are 0 where an axis, or a position, is fixed. The
offset of a cone is its apex's position along the axis."""

NUMBERS: dict[tuple[str, str], tuple[int, int]] = {
    ("sphere", "radius"): (3, 8),
    ("cylinder", "radius"): (4, 8),
    ("cone", "half_angle"): (4, 6),
    ("torus", "major_radius"): (5, 7),
    ("torus", "minor_radius"): (6, 8),
}
"""Kind and parameter -> component of a step, and place in a row."""

APEX_TRIPLES = 24

TOUCHES = 1e-9
TOUCHES_ANGLE = 1e-9
"""A number this close to its bound, relatively, is at it; so is an axis this close [rad] to its limit."""


@dataclass(frozen=True, eq=False)
class Limits:
    """The constraints on one kind, in the frame of a cloud.

    Attributes
    ----------
    kind : that they act on
    pivot : (3,) the fixed position, which becomes the origin; zero where there is none
    pinned : whether there is one
    frozen : (7,) components of a step that are 0
    low, high : (3,) bounds of the numbers of a row from row[6] on, infinite where there are none
    reference : (3,) unit direction that the axis or normal is constrained by, or None
    max_angle : largest angle [rad] between the two
    """

    kind: str
    pivot: Array
    pinned: bool
    frozen: np.ndarray
    low: Array
    high: Array
    reference: Array | None
    max_angle: float

    @classmethod
    def of(cls, constraints: Constraints, kind: str, frame: Frame) -> Self | None:
        """The limits of a kind, or None where no constraint acts on it."""
        acting = constraints.on(kind)
        if not acting:
            return None
        pivot, pinned, reference = np.zeros(3), False, None
        max_angle = np.inf
        frozen = np.zeros(MOST_COORDINATES, bool)
        low, high = np.full(3, -np.inf), np.full(3, np.inf)
        for name, value in acting.items():
            if isinstance(value, Range):
                component, place = NUMBERS[kind, name]
                length = 1.0 if name == "half_angle" else frame.scale
                frozen[component] = value.fixed
                low[place - 6] = value.low / length if value.low > 0.0 else -np.inf
                high[place - 6] = value.high / length
            elif isinstance(value, Direction):
                reference, max_angle = value.unit, value.max_angle
                frozen[list(TILTS[kind])] = max_angle == 0.0
            else:
                pivot, pinned = frame.normalize(np.array(value)), True
                frozen[list(SHIFTS[kind])] = True
        return cls(kind, pivot, pinned, frozen, low, high, reference, max_angle)

    def releasing(self, name: str) -> Self:
        """These limits without the one on a radius or half-angle."""
        component, place = NUMBERS[self.kind, name]
        frozen, low, high = self.frozen.copy(), self.low.copy(), self.high.copy()
        frozen[component] = False
        low[place - 6], high[place - 6] = -np.inf, np.inf
        return replace(self, frozen=frozen, low=low, high=high)

    def active(self, row: Array) -> dict[str, tuple[bool, bool]]:
        """Which numbers of a row (9,) are at a bound: whether they are fixed, and whether it is the upper."""
        found = {}
        for (kind, name), (component, place) in NUMBERS.items():
            if kind != self.kind:
                continue
            for bound, upper in ((self.low[place - 6], False), (self.high[place - 6], True)):
                if abs(row[place] - bound) <= TOUCHES * abs(bound) < np.inf:
                    found[name] = (bool(self.frozen[component]), upper)
        return found

    def free_steps(self, row: Array, dof: int) -> Array:
        """Orthonormal directions (dof, k) of the steps from a row (9,) that no active limit holds."""
        held = [np.eye(dof)[component] for component in np.flatnonzero(self.frozen[:dof])]
        held += [np.eye(dof)[NUMBERS[self.kind, name][0]] for name in self.active(row)]
        if self.reference is not None and self.max_angle > 0.0:
            towards = np.array(basis(row[:3])) @ self.reference
            if np.arcsin(min(float(np.linalg.norm(towards)), 1.0)) >= self.max_angle - TOUCHES_ANGLE:
                held.append(np.concatenate([towards / np.linalg.norm(towards), np.zeros(dof - 2)]))
        if not held:
            return np.eye(dof)
        _, sizes, directions = np.linalg.svd(np.array(held))
        return np.asarray(directions[np.count_nonzero(sizes > 1e-9) :].T)

    def held(self, row: Array) -> int:
        """How many of its parameters fixed values, and limits that are active, hold at a row (9,)."""
        dof = PRIMITIVES[self.kind].dof
        return dof - self.free_steps(row, dof).shape[1]

    @property
    def bounds(self) -> Bounds:
        """All that the compiled steps need."""
        bounded = self.reference is not None and self.max_angle > 0.0
        return Bounds(
            frozen=self.frozen,
            low=self.low,
            high=self.high,
            reference=Z_AXIS if self.reference is None else self.reference,
            most_tilt=self.max_angle if bounded else np.inf,
        )

    def guesses(self, found: Array, points: Array, normals: Array, rng: np.random.Generator) -> Array:
        """Rows (K, 9) within the limits: the guesses found without them (J, 9), and those that they lead to.

        `points` (N, 3) and `found` are in the frame of the cloud, the result is relative to the pivot.
        """
        candidates = [found]
        if self.reference is not None:
            candidates.append(_along(self.kind, self.reference, points, normals))
        if self.pinned and self.kind == "cone":
            candidates.append(_from_apex(self.pivot, points, rng))
        return np.array([self.impose(row, points - self.pivot) for row in np.vstack(candidates)])

    def impose(self, row: Array, points: Array) -> Array:
        """The row (9,) moved within the limits, as close to the points (N, 3) as a linear step brings it.

        Both are relative to the pivot.
        """
        row = row.copy()
        if self.pinned:
            row[3:6], row[8] = 0.0, 0.0 if self.kind == "cone" else row[8]
        if self.reference is not None:
            row[:3] = self._nearest_axis(row[:3])
        _IMPOSE[self.kind](row, points, self)
        return row

    def _nearest_axis(self, axis: Array) -> Array:
        """The direction nearest to `axis` within the largest angle of the reference or its opposite."""
        assert self.reference is not None
        reference = self.reference if axis @ self.reference >= 0.0 else -self.reference
        across = axis - (axis @ reference) * reference
        length = float(np.linalg.norm(across))
        if self.max_angle == 0.0 or np.arctan2(length, axis @ reference) > self.max_angle:
            axis = np.cos(self.max_angle) * reference + np.sin(self.max_angle) * across / (length + TINY)
        return axis

    def clip(self, row: Array, place: int) -> float:
        """Bring the number at this place of a row into its bounds; by how much it grew."""
        before = row[place]
        row[place] = min(max(before, self.low[place - 6]), self.high[place - 6])
        return float(row[place] - before)


def _along(kind: str, direction: Array, points: Array, normals: Array) -> Array:
    """Guesses (K, 9) of a kind whose axis or normal is known."""
    if kind == "plane":
        return rows(direction, np.median(points, axis=0))[None]
    seen = Seen.along(direction[None], points, normals)
    if kind == "torus":
        return Torus.rows_about(seen, revolution_axis(points, normals))
    return Cone.rows_about(seen) if kind == "cone" else Cylinder.rows_about(seen)


def _from_apex(apex: Array, points: Array, rng: np.random.Generator) -> Array:
    """Cones (K, 9) of an apex through three random points each: directions from it make one angle with the
    axis, so their tips lie in a plane across it. The angle is left to the points."""
    directions = points - apex
    directions /= np.linalg.norm(directions, axis=1, keepdims=True) + TINY
    tips = directions[random_subsets(len(points), 3, APEX_TRIPLES, rng)]
    axes = cross(tips[:, 1] - tips[:, 0], tips[:, 2] - tips[:, 0])
    lengths = np.linalg.norm(axes, axis=1)
    axes = axes[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    feet = np.array([foot_of_origin(apex, axis) for axis in axes]).reshape(-1, 3)
    return rows(axes, feet, np.pi / 4, offset=-(axes @ apex) * np.sin(np.pi / 4))


def _impose_plane(row: Array, points: Array, limits: Limits) -> None:
    if not limits.pinned:
        row[3:6] = np.median(points @ row[:3]) * row[:3]


def _impose_sphere(row: Array, points: Array, limits: Limits) -> None:
    relative = points - row[3:6]
    distance = np.linalg.norm(relative, axis=1)
    if limits.pinned:
        row[8] = np.median(distance)
    grown = limits.clip(row, 8)
    if not limits.pinned:
        row[3:6] -= grown * (relative / (distance + TINY)[:, None]).mean(axis=0)


def _impose_cylinder(row: Array, points: Array, limits: Limits) -> None:
    row[3:6] = foot_of_origin(row[3:6], row[:3])
    radial, rho, _ = around_axis(points, row[3:6], row[:3])
    if limits.pinned:
        row[8] = np.median(rho)
    grown = limits.clip(row, 8)
    if not limits.pinned:
        row[3:6] -= grown * (radial / (rho + TINY)[:, None]).mean(axis=0)


def _impose_cone(row: Array, points: Array, limits: Limits) -> None:
    row[3:6] = foot_of_origin(row[3:6], row[:3])
    radial, rho, height = around_axis(points, row[3:6], row[:3])
    if limits.pinned:
        if np.median(height) < 0.0:
            row[:3], height = -row[:3], -height
        row[6] = np.median(np.arctan2(rho, height))
    apex = row[3:6] - row[8] / np.sin(row[6]) * row[:3]
    grown = limits.clip(row, 6)
    if not limits.pinned:
        if limits.reference is None:
            lean = (radial / (rho + TINY)[:, None]).mean(axis=0)
            row[:3] = unit(np.cos(grown) * row[:3] - np.sin(grown) * lean)
            row[3:6] = foot_of_origin(apex, row[:3])
            _, rho, height = around_axis(points, row[3:6], row[:3])
        row[8] = np.median(rho * np.cos(row[6]) - height * np.sin(row[6]))


def _impose_torus(row: Array, points: Array, limits: Limits) -> None:
    radial, rho, height = around_axis(points, row[3:6], row[:3])
    grown = limits.clip(row, 7)
    if not limits.pinned:
        row[3:6] -= grown * (radial / (rho + TINY)[:, None]).mean(axis=0)
        _, rho, height = around_axis(points, row[3:6], row[:3])
    row[8] = np.median(np.hypot(rho - row[7], height))
    limits.clip(row, 8)


_IMPOSE = {
    "plane": _impose_plane,
    "sphere": _impose_sphere,
    "cylinder": _impose_cylinder,
    "cone": _impose_cone,
    "torus": _impose_torus,
}


def dof_within(kind: str, limits: Limits | None) -> int:
    """Points that determine a kind: as many as it has parameters that are not fixed.

    Bounded ones are free until the points have chosen a bound.
    """
    return PRIMITIVES[kind].dof - (0 if limits is None else int(np.count_nonzero(limits.frozen)))


def moved(primitive: Primitive, by: Array) -> Primitive:
    """The primitive shifted by (3,): from the frame of a pivot back to that of the cloud."""
    return primitive.transformed(np.eye(3), by, 1.0)
