"""How much may be read, and fitted."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from .errors import TooLargeError

GIB = 1024**3
_SMALL = 1024**2
RATIO = 100
"""What strangers send unpacks to at most so many times its size: half-empty grids of depth cameras, the most
compressible of clouds, to some 50. What unpacks to 1 MiB or less may do so from anything."""


@dataclass(frozen=True)
class Limits:
    """Most points of a cloud and of one in JSON, and most bytes that data unpacks to.

    `ratio` is how many times its size it may unpack to, so that work costs its sender something.
    `criterion_points` are the most points that are fitted by a criterion, where it has a limit. None is any.
    """

    points: int | None = None
    json_points: int | None = None
    unpacked_bytes: int = 2 * GIB
    ratio: int | None = None
    criterion_points: Mapping[str, int] = field(default_factory=dict)

    def check_points(self, n_points: int, field: str = "file") -> None:
        """Raise `TooLargeError` when a cloud holds more points than may be read."""
        if self.points is not None and n_points > self.points:
            raise TooLargeError(field, f"{n_points} points; the limit is {self.points}", f"{n_points} points")

    def check_criterion(self, n_points: int, criterion: str) -> None:
        """Raise `TooLargeError` when a criterion may not be done in time with so many points."""
        most = self.criterion_points.get(criterion)
        if most is not None and n_points > most:
            message = (
                f"{n_points} points; the limit of the criterion {criterion} is {most}, for it to be done in "
                "time: send fewer points, or choose a criterion with a higher limit (GET /capabilities)"
            )
            raise TooLargeError("criterion", message, f"{n_points} points")

    def check_unpacked(self, n_bytes: int, n_packed: int, field: str = "file") -> None:
        """Raise `TooLargeError` when compressed data unpacks to more bytes than may be read."""
        if n_bytes > self.unpacked_bytes:
            message = f"it unpacks to more than {self.unpacked_bytes} bytes, the limit"
            raise TooLargeError(field, message, f"{n_bytes} bytes or more")
        if self.ratio is not None and n_bytes > max(_SMALL, self.ratio * n_packed):
            message = f"{n_packed} bytes unpack to more than {self.ratio} times as many, the limit"
            raise TooLargeError(field, message, f"{n_bytes} bytes or more")


UNLIMITED = Limits()
