"""Results in the order of the work, with a bound on what is begun."""

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable
from contextlib import aclosing
from functools import partial

import pytest

from primfit.app.service.ordered import in_order


class _Work:
    """Jobs that finish when they are told to, and what happened to them."""

    def __init__(self, n_jobs: int) -> None:
        self.n_jobs, self.begun, self.cancelled = n_jobs, 0, 0
        self.closed = False
        self.finish = [asyncio.Event() for _ in range(n_jobs)]

    async def jobs(self) -> AsyncGenerator[Callable[[], Awaitable[int]], None]:
        try:
            for i in range(self.n_jobs):
                yield partial(self._do, i)
        finally:
            self.closed = True

    async def _do(self, i: int) -> int:
        self.begun += 1
        try:
            await self.finish[i].wait()
        except asyncio.CancelledError:
            self.cancelled += 1
            raise
        if i == 13:
            raise ZeroDivisionError
        return i


async def _settle() -> None:
    for _ in range(20):
        await asyncio.sleep(0)


def test_results_come_in_order_whichever_is_done_first() -> None:
    async def run() -> None:
        work = _Work(5)
        results = in_order(work.jobs(), 3)
        for i in (2, 1, 4, 3):
            work.finish[i].set()
        first = asyncio.ensure_future(anext(results))
        await _settle()
        assert not first.done() and work.begun == 3
        work.finish[0].set()
        assert [await first] + [i async for i in results] == [0, 1, 2, 3, 4]
        assert work.closed

    asyncio.run(run())


def test_results_that_nobody_takes_hold_the_work_back() -> None:
    async def run() -> None:
        work = _Work(10)
        for event in work.finish:
            event.set()
        async with aclosing(in_order(work.jobs(), 3)) as results:
            assert await anext(results) == 0
            await _settle()
            assert work.begun == 3
            assert await anext(results) == 1
            await _settle()
            assert work.begun == 4
        await _settle()
        assert work.closed and work.begun == 4

    asyncio.run(run())


def test_closed_or_failed_it_cancels_what_is_under_way() -> None:
    async def run() -> None:
        work = _Work(20)
        async with aclosing(in_order(work.jobs(), 4)) as results:
            work.finish[0].set()
            assert await anext(results) == 0
            await _settle()
        await _settle()
        assert work.cancelled == 3 and work.closed

        work = _Work(20)
        for event in work.finish[:14]:
            event.set()
        seen = []
        with pytest.raises(ZeroDivisionError):
            async for i in in_order(work.jobs(), 4):
                seen.append(i)
        await _settle()
        assert seen == list(range(13)) and work.cancelled == work.begun - 14 > 0 and work.closed

    asyncio.run(run())


def test_what_goes_wrong_in_the_source_is_raised() -> None:
    async def broken() -> AsyncGenerator[Callable[[], Awaitable[int]], None]:
        yield partial(asyncio.sleep, 0, 7)
        raise ZeroDivisionError

    async def run() -> None:
        results = in_order(broken(), 4)
        assert await anext(results) == 7
        with pytest.raises(ZeroDivisionError):
            await anext(results)

    asyncio.run(run())
