"""What is made small: the largest of these values, which a criterion of extreme points is about.

With the signed distance d, and with  rho = d + radius  from the center or axis,

=======================  =========  ===========================
criterion                values     what is varied
=======================  =========  ===========================
minimum zone             d and -d   all coordinates of the kind
minimum circumscribed    rho        all but the radius
maximum inscribed        -rho       all but the radius
=======================  =========  ===========================

Terms as in ISO 14405-1.
"""

from dataclasses import dataclass

import numpy as np

from ..geometry.vectors import Array
from ..primitives.primitive import Primitive
from ..solver.refine import linearize_along


@dataclass(frozen=True)
class Task:
    """Which values g are made small: with these signs, of d, or of rho where the radius is left out."""

    signs: tuple[float, ...]
    radial: bool

    def values(self, primitive: Primitive, points: Array) -> Array:
        """g (S N,) for S signs."""
        distance = primitive.signed_distance(points)
        if self.radial:
            distance = distance + primitive.row()[8]
        return np.concatenate([sign * distance for sign in self.signs])

    def worst(self, primitive: Primitive, points: Array) -> float:
        return float(self.values(primitive, points).max())

    def slopes(self, reference: Primitive, primitive: Primitive, points: Array) -> Array:
        """dg (S N, k) by a step in the coordinates of the reference; the k-th is the last but the radius."""
        jacobian = linearize_along(reference, primitive, points)[1]
        jacobian = jacobian[:, :-1] if self.radial else jacobian
        return np.concatenate([sign * jacobian for sign in self.signs])

    def padded(self, step: Array) -> Array:
        """The step (dof,) that one in the coordinates that are varied is."""
        return np.append(step, 0.0) if self.radial else step


MINIMUM_ZONE = Task((1.0, -1.0), radial=False)
MINIMUM_CIRCUMSCRIBED = Task((1.0,), radial=True)
MAXIMUM_INSCRIBED = Task((-1.0,), radial=True)
