"""Leases end when nothing is heard, by the watcher's own clock, and never because a clock jumped."""

from primfit.app.jobs.clock import SteadyClock
from primfit.app.jobs.watch import PATIENCE, Beat, Watch


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def _looks(watch: Watch, clock: Clock, seconds: float, beat: int) -> list[Beat]:
    """What is silent at the end of so many seconds of looks."""
    silent: list[Beat] = []
    for _ in range(int(seconds * 2)):
        clock.now += 0.5
        silent = watch.silent([Beat("j", 1, beat)])
    return silent


def test_a_beat_that_stays_the_same_is_silent_after_some_time() -> None:
    clock = Clock()
    watch = Watch(clock)
    assert _looks(watch, clock, PATIENCE, 1) == []
    assert _looks(watch, clock, 1.0, 1) == [Beat("j", 1, 1)]
    assert _looks(watch, clock, PATIENCE, 2) == []


def test_who_did_not_look_knows_nothing() -> None:
    clock = Clock()
    watch = Watch(clock)
    _looks(watch, clock, 1.0, 1)
    clock.now += 1e6  # the machine slept, or the database did not answer
    assert watch.silent([Beat("j", 1, 1)]) == []


def test_the_time_of_a_service_does_not_jump() -> None:
    wall, steady = Clock(), Clock()
    wall.now = 1e9
    clock = SteadyClock(wall, steady)
    wall.now -= 1e8
    steady.now += 60.0
    assert clock() == 1e9 + 60.0
