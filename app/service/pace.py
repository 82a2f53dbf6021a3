"""How fast bytes have to move: at a smallest rate in each stretch of time, and all within a limit."""


class Pace:
    """Watches the bytes of one body or one answer. Only the seconds count in which the client is awaited.

    Parameters
    ----------
    stretch
        Seconds over which the rate is averaged.
    rate
        Least bytes a second.
    limit
        Seconds in total.
    """

    __slots__ = ("_limit", "_moved", "_rate", "_seconds", "_stretch", "_total")

    def __init__(self, stretch: float, rate: float, limit: float) -> None:
        self._stretch, self._rate, self._limit = stretch, rate, limit
        self.restart()

    def restart(self) -> None:
        """A new body or answer begins."""
        self._total = self._seconds = 0.0
        self._moved = 0

    def caught_up(self) -> None:
        """Nothing is awaited for the moment: a new stretch begins."""
        self._seconds, self._moved = 0.0, 0

    def moved(self, n_bytes: int) -> None:
        """So many bytes more have arrived."""
        self._moved += n_bytes

    def complaint(self, seconds: float) -> str | None:
        """What is wrong after so many seconds more in which the client was awaited, None if nothing is."""
        self._total += seconds
        if self._total > self._limit:
            return f"incomplete after {self._limit:g} s"
        self._seconds += seconds
        if self._seconds >= self._stretch:
            if self._moved < self._rate * self._stretch:
                return f"{self._moved} bytes in {self._stretch:g} s; {self._rate:g} a second are needed"
            self.caught_up()
        return None
