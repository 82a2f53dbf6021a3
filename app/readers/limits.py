"""How much a reader may take in."""

from dataclasses import dataclass

from .errors import TooLargeError

GIB = 1024**3


@dataclass(frozen=True)
class Limits:
    """Most points of a cloud and of one in JSON, None for any number; most bytes that data unpacks to."""

    points: int | None = None
    json_points: int | None = None
    unpacked_bytes: int = 2 * GIB

    def check_points(self, n_points: int, field: str = "file") -> None:
        """Raise `TooLargeError` when a cloud holds more points than may be read."""
        if self.points is not None and n_points > self.points:
            raise TooLargeError(field, f"{n_points} points; the limit is {self.points}", f"{n_points} points")

    def check_unpacked(self, n_bytes: int, field: str = "file") -> None:
        """Raise `TooLargeError` when compressed data unpacks to more bytes than may be read."""
        if n_bytes > self.unpacked_bytes:
            message = f"it unpacks to more than {self.unpacked_bytes} bytes, the limit"
            raise TooLargeError(field, message, f"{n_bytes} bytes or more")


UNLIMITED = Limits()
