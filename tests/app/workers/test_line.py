"""The line in front of the workers: shares of lanes, heavy jobs, and what a newcomer has to expect."""

import asyncio
from collections.abc import Awaitable, Callable

import pytest

from primfit.app.workers.line import Line


async def _wanted() -> bool:
    return False


def _with_line(use: Callable[[Line[str]], Awaitable[None]], workers: str) -> None:
    async def run() -> None:
        line: Line[str] = Line(("a", "b"), len(workers))
        for worker in workers:
            line.free(worker)
        await asyncio.wait_for(use(line), 30)

    asyncio.run(run())


async def _done(line: Line[str], lane: str, seconds: float, heavy: bool = False) -> None:
    turn = await line.turn(lane, heavy, None, _wanted)
    assert turn is not None
    line.done(turn, seconds)
    line.free(turn.worker)


def test_lanes_share_the_time_of_the_workers() -> None:
    """Jobs of one lane take four times as long as those of the other, which gets four times as many turns."""
    order: list[str] = []

    async def use(line: Line[str]) -> None:
        async def one(lane: str, seconds: float) -> None:
            await _done(line, lane, seconds)
            order.append(lane)

        held = await line.turn("a", False, None, _wanted)
        assert held is not None
        jobs = [one("a", 1.0) for _ in range(40)] + [one("b", 4.0) for _ in range(40)]
        tasks = [asyncio.ensure_future(job) for job in jobs]
        await asyncio.sleep(0)
        line.done(held, None)
        line.free(held.worker)
        await asyncio.gather(*tasks)

    _with_line(use, "w")
    until = order[: 40 + 40 // 4]
    assert 36 <= until.count("a") <= 40


def test_a_lane_that_was_idle_has_saved_nothing_up() -> None:
    order: list[str] = []

    async def use(line: Line[str]) -> None:
        for _ in range(50):
            await _done(line, "a", 1.0)
        held = await line.turn("a", False, None, _wanted)
        assert held is not None

        async def one(lane: str) -> None:
            await _done(line, lane, 1.0)
            order.append(lane)

        tasks = [asyncio.ensure_future(one(lane)) for lane in "bbbbbbbbaaaaaaaa"]
        await asyncio.sleep(0)
        line.done(held, 1.0)
        line.free(held.worker)
        await asyncio.gather(*tasks)

    _with_line(use, "w")
    assert order[:8].count("a") >= 3


def test_heavy_jobs_leave_one_worker() -> None:
    async def use(line: Line[str]) -> None:
        first = await line.turn("a", True, None, _wanted)
        assert first is not None
        assert not line.has_room(True) and line.has_room(False)
        second = asyncio.ensure_future(line.turn("a", True, None, _wanted))
        await _done(line, "b", 1.0)
        assert not second.done()
        line.done(first, 1.0)
        line.free(first.worker)
        assert await second is not None

    _with_line(use, "vw")


def test_one_worker_does_heavy_jobs_too() -> None:
    async def use(line: Line[str]) -> None:
        await _done(line, "a", 1.0, heavy=True)

    _with_line(use, "w")


def test_a_turn_that_does_not_come_in_time_is_given_up() -> None:
    async def use(line: Line[str]) -> None:
        held = await line.turn("a", False, None, _wanted)
        assert held is not None
        with pytest.raises(TimeoutError):
            await line.turn("a", False, asyncio.get_running_loop().time() + 0.1, _wanted)
        assert line.n_waiting() == 0
        line.done(held, 1.0)
        line.free(held.worker)
        await _done(line, "b", 1.0)

    _with_line(use, "w")


def test_what_has_to_be_waited_grows_with_the_line() -> None:
    async def use(line: Line[str]) -> None:
        assert line.seconds_to_wait("a") == 0.0
        held = await line.turn("a", False, None, _wanted)
        assert held is not None
        line.done(held, 2.0)
        tasks = [asyncio.ensure_future(line.turn("a", False, None, _wanted)) for _ in range(3)]
        await asyncio.sleep(0)
        assert line.seconds_to_wait("a") == 2.0 * 4
        assert line.seconds_to_wait("b") == 0.0
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        assert line.n_waiting() == 0

    _with_line(use, "w")


def test_what_was_cut_off_tells_nothing_of_its_lane() -> None:
    """Else a line whose jobs are cut off at once looks quick, and takes more and more of them."""

    async def use(line: Line[str]) -> None:
        for seconds, finished in ((2.0, True), (0.01, False), (60.0, False)):
            turn = await line.turn("a", False, None, _wanted)
            assert turn is not None
            line.done(turn, seconds, finished)
            line.free(turn.worker)
        assert line.seconds_of_work("a") == 2.0

    _with_line(use, "w")
