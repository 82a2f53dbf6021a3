"""Which services have gone silent, told by a clock that is one's own."""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

PATIENCE = 4.0
"""Seconds without a sign of life after which a service counts as dead: eight of its beats."""
_LOOK = 1.0
"""A longer time between two looks counts as this: whoever could not look cannot say who was silent."""


@dataclass(frozen=True)
class Beat:
    """The last sign of life of the service that works on a job."""

    job_id: str
    attempt: int
    beat: int


class Watch:
    """Looks at beats again and again.

    A lease holds no time, so that clocks which differ or jump do not matter: it ends when its beat has stayed
    the same for `PATIENCE` seconds of the monotonic clock of whoever looks.
    """

    def __init__(self, steady: Callable[[], float] = time.monotonic) -> None:
        self._steady = steady
        self._looked = steady()
        self._silence: dict[Beat, float] = {}

    def silent(self, beats: Iterable[Beat]) -> list[Beat]:
        """Those that stayed the same for too long; `beats` are all that there are now."""
        now = self._steady()
        passed = min(now - self._looked, _LOOK)
        self._looked = now
        before = self._silence
        self._silence = {beat: before[beat] + passed if beat in before else 0.0 for beat in beats}
        return [beat for beat, seconds in self._silence.items() if seconds > PATIENCE]
