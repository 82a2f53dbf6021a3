"""The constraints on one kind as the compiled steps obey them, and starts that obey them too.

A fixed center, apex or point becomes the origin of the frame: the foot of the origin on an axis is then that
point itself, tilts turn about it, and fixing it means not to shift.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ..cloud.frame import Frame
from ..geometry.vectors import TINY, Z_AXIS, Array, basis
from ..guesses.oriented import Oriented
from ..primitives import PRIMITIVES, is_angle
from ..primitives.primitive import Known, Primitive
from ..request.constraints import TOUCHES, Constraints, Direction, Range
from ._limits import Bounds


@dataclass(frozen=True, eq=False)
class Limits:
    """The constraints on one kind, in the frame of a cloud.

    Attributes
    ----------
    kind : that they act on
    pivot : (3,) the fixed position, which becomes the origin; zero where there is none
    pinned : whether there is one
    frozen : (dof,) components of a step that are 0
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
        chart = PRIMITIVES[kind].chart
        frozen = np.zeros(PRIMITIVES[kind].dof, bool)
        low, high = np.full(3, -np.inf), np.full(3, np.inf)
        for name, value in acting.items():
            if isinstance(value, Range):
                component, place = chart.numbers[name]
                length = 1.0 if is_angle(name) else frame.scale
                frozen[component] = value.fixed
                low[place - 6] = value.low / length if value.low > 0.0 else -np.inf
                high[place - 6] = value.high / length
            elif isinstance(value, Direction):
                reference, max_angle = value.unit, value.max_angle
                frozen[list(chart.tilts)] = max_angle == 0.0
            else:
                pivot, pinned = frame.normalize(np.array(value)), True
                frozen[list(chart.shifts)] = True
        return cls(kind, pivot, pinned, frozen, low, high, reference, max_angle)

    def releasing(self, name: str) -> Self:
        """These limits without the one on a radius or half-angle."""
        component, place = PRIMITIVES[self.kind].chart.numbers[name]
        frozen, low, high = self.frozen.copy(), self.low.copy(), self.high.copy()
        frozen[component] = False
        low[place - 6], high[place - 6] = -np.inf, np.inf
        return replace(self, frozen=frozen, low=low, high=high)

    def active(self, row: Array) -> dict[str, tuple[bool, bool]]:
        """Which numbers of a row (9,) are at a bound: whether they are fixed, and whether it is the upper."""
        found = {}
        for name, (component, place) in PRIMITIVES[self.kind].chart.numbers.items():
            for bound, upper in ((self.low[place - 6], False), (self.high[place - 6], True)):
                if abs(row[place] - bound) <= TOUCHES * abs(bound) < np.inf:
                    found[name] = (bool(self.frozen[component]), upper)
        return found

    def free_steps(self, row: Array) -> Array:
        """Orthonormal directions (dof, k) of the steps from a row (9,) that no active limit holds."""
        dof, numbers = PRIMITIVES[self.kind].dof, PRIMITIVES[self.kind].chart.numbers
        held = [np.eye(dof)[component] for component in np.flatnonzero(self.frozen)]
        held += [np.eye(dof)[numbers[name].component] for name in self.active(row)]
        if self.reference is not None and self.max_angle > 0.0:
            towards = np.array(basis(row[:3])) @ self.reference
            if np.arcsin(min(float(np.linalg.norm(towards)), 1.0)) >= self.max_angle - TOUCHES:
                held.append(np.concatenate([towards / np.linalg.norm(towards), np.zeros(dof - 2)]))
        if not held:
            return np.eye(dof)
        _, sizes, directions = np.linalg.svd(np.array(held))
        return np.asarray(directions[np.count_nonzero(sizes > 1e-9) :].T)

    def held(self, row: Array) -> int:
        """How many of its parameters fixed values, and limits that are active, hold at a row (9,)."""
        return len(self.frozen) - self.free_steps(row).shape[1]

    @property
    def bounds(self) -> Bounds:
        """All that the compiled steps need."""
        bounded = self.reference is not None and self.max_angle > 0.0
        return Bounds(
            frozen=self.frozen,
            slots=self._slots,
            low=self.low,
            high=self.high,
            reference=Z_AXIS if self.reference is None else self.reference,
            most_tilt=self.max_angle if bounded else np.inf,
        )

    @property
    def _slots(self) -> list[int]:
        """The component of a step that adds to each number from row[6] on; -1 without a name."""
        slots = [-1, -1, -1]
        for component, place in PRIMITIVES[self.kind].chart.numbers.values():
            slots[place - 6] = component
        return slots

    def guesses(self, found: Array, oriented: Oriented, rng: np.random.Generator) -> Array:
        """Rows (K, 9) within the limits: the guesses found without them (J, 9), and those that they lead to.

        The points and `found` are in the frame of the cloud, the result is relative to the pivot.
        """
        known = Known(self.reference, self.pivot if self.pinned else None)
        given = PRIMITIVES[self.kind].guesses_given(known, oriented, rng)
        return np.array([self.impose(row, oriented.points - self.pivot) for row in np.vstack([found, given])])

    def impose(self, row: Array, points: Array) -> Array:
        """The row (9,) moved within the limits, as close to the points (N, 3) as a linear step brings it.

        Both are relative to the pivot.
        """
        row = row.copy()
        if self.pinned:
            row[3:6] = 0.0
        if self.reference is not None:
            row[:3] = self._nearest_axis(row[:3])
        PRIMITIVES[self.kind].impose(row, points, self)
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


def moved(primitive: Primitive, by: Array) -> Primitive:
    """The primitive shifted by (3,): from the frame of a pivot back to that of the cloud."""
    return primitive.transformed(np.eye(3), by, 1.0)
