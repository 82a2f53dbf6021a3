"""Whether what a caller gives is near enough to the cloud for distances from there to mean anything."""

import numpy as np

from ..cloud.frame import Frame
from ..errors import InvalidOptionError
from ..primitives import is_angle
from ..primitives.primitive import Primitive
from .constraints import Constraints, Direction, Range

FARTHEST = 1e9
"""Extents of the cloud. Far beyond that every cloud lies within the rounding of some surface."""


def check_reach(constraints: Constraints, guess: Primitive | None, frame: Frame) -> None:
    """Raise `InvalidOptionError` for a position, a least length or a guess that is farther or larger."""
    with np.errstate(over="ignore", invalid="ignore"):
        for name, value in constraints.given.items():
            if isinstance(value, Range) and not is_angle(name):
                _check(f"constraints.{name}", np.float64(value.low) / frame.scale)
            elif not isinstance(value, Range | Direction):
                _check(f"constraints.{name}", np.max(np.abs(frame.normalize(np.array(value)))))
        if guess is not None:
            _check("initial_guess", np.max(np.abs(frame.bring(guess).row())))


def _check(field: str, extents: float) -> None:
    if not extents <= FARTHEST:
        raise InvalidOptionError(
            f"{field} is {extents:.1e} extents of the cloud away, or as large; the limit is {FARTHEST:.0e}",
            field,
        )
