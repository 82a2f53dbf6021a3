"""The time of a service: read once from the system's clock, and from there on it never jumps."""

import time
from collections.abc import Callable


def _since_boot() -> float:
    """Seconds that pass also while the machine sleeps, where the system counts them."""
    return time.clock_gettime(time.CLOCK_BOOTTIME) if hasattr(time, "CLOCK_BOOTTIME") else time.monotonic()


class SteadyClock:
    """Seconds since 1970.

    A clock that is set while the service runs moves none of its times, so no job is kept for a day less. No
    lease rests on it: see `app.jobs.watch`.
    """

    def __init__(
        self, wall: Callable[[], float] = time.time, steady: Callable[[], float] = _since_boot
    ) -> None:
        self._steady = steady
        self._offset = wall() - steady()

    def __call__(self) -> float:
        return self._offset + self._steady()
