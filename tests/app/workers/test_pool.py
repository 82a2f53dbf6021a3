"""The pool by itself: jobs of the standard library stand for fits that hang, crash or succeed."""

import asyncio
import math
import os
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from primfit.app.wire.problems import BusyError, TimeLimitError, WorkerDiedError
from primfit.app.workers.pool import WorkerPool
from tests.app.serving import PATIENCE


async def _wanted() -> bool:
    return False


async def _abandoned() -> bool:
    return True


def _with_pool(
    work: Callable[[Any], Any], use: Callable[[WorkerPool], Awaitable[None]], **options: Any
) -> None:
    """Run `use` with a pool of one worker that does `work`."""

    async def run() -> None:
        pool = WorkerPool(1, os.getpid, work, **options)
        pool.start()
        try:
            await use(pool)
        finally:
            pool.stop()

    asyncio.run(run())


async def _until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(PATIENCE):
        while not condition():
            await asyncio.sleep(0.01)


def test_jobs_are_done_in_another_process_one_after_the_other() -> None:
    async def use(pool: WorkerPool) -> None:
        assert await asyncio.gather(*(pool.run(float(n), _wanted) for n in (1, 4, 9))) == [1.0, 2.0, 3.0]
        assert pool.greeting != os.getpid()
        assert pool.n_warm == 1

    _with_pool(math.sqrt, use)


def test_a_job_over_the_limit_is_killed_and_the_next_one_done() -> None:
    async def use(pool: WorkerPool) -> None:
        first = pool.greeting
        with pytest.raises(TimeLimitError, match=r"1\.5 s"):
            await pool.run(60.0, _wanted)
        assert await pool.run(0.0, _wanted) is None
        assert pool.greeting != first
        assert pool.n_restarts == 1

    _with_pool(time.sleep, use, time_limit=1.5)


def test_a_worker_that_ends_is_reported_and_replaced() -> None:
    async def use(pool: WorkerPool) -> None:
        for _ in range(2):
            with pytest.raises(WorkerDiedError):
                await pool.run(3, _wanted)

    _with_pool(os._exit, use)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="holds the worker up with a named pipe")
def test_more_than_may_wait_is_refused(tmp_path: Path) -> None:
    held, free = tmp_path / "held", tmp_path / "free"
    os.mkfifo(held)
    free.touch()

    async def use(pool: WorkerPool) -> None:
        busy = asyncio.create_task(pool.run(held, _wanted))
        await _until(lambda: pool.n_busy == 1)
        waiting = asyncio.create_task(pool.run(free, _wanted))
        await _until(lambda: pool.n_waiting == 1)
        with pytest.raises(BusyError):
            await pool.run(free, _wanted)
        await asyncio.to_thread(held.write_bytes, b"go on")
        assert await asyncio.gather(busy, waiting) == [b"go on", b""]
        assert (pool.n_busy, pool.n_waiting, pool.n_restarts) == (0, 0, 0)

    _with_pool(Path.read_bytes, use, queue_size=1)


def test_an_abandoned_job_is_not_begun() -> None:
    async def use(pool: WorkerPool) -> None:
        assert await pool.run(3, _abandoned) is None
        assert pool.n_warm == 1

    _with_pool(os._exit, use)


def test_a_cancelled_caller_does_not_free_a_busy_worker() -> None:
    async def use(pool: WorkerPool) -> None:
        task = asyncio.create_task(pool.run(0.5, _wanted))
        await asyncio.sleep(0.2)
        task.cancel()
        assert await pool.run(0.0, _wanted) is None

    _with_pool(time.sleep, use)


def test_batches_take_turns_and_let_requests_in_between() -> None:
    """Two batches of eight and four, and a request that comes last of all but does not wait for them."""
    order: list[str] = []

    async def use(pool: WorkerPool) -> None:
        await pool.run(0.0, _wanted)

        async def do(run: Callable[..., Awaitable[Any]], name: str) -> None:
            await run(0.02, _wanted)
            order.append(name)

        with pool.batch() as first, pool.batch() as second:
            jobs = [do(first, "a") for _ in range(8)] + [do(second, "b") for _ in range(4)]
            tasks = [asyncio.ensure_future(job) for job in jobs]
            await asyncio.sleep(0.01)
            await do(pool.run, "request")
            await asyncio.gather(*tasks)

    _with_pool(time.sleep, use)
    assert order.index("request") <= 2
    without = "".join(name for name in order if name != "request")
    assert without == "abababab" + "aaaa"


def test_open_batches_are_limited_but_their_jobs_wait_without_end() -> None:
    async def use(pool: WorkerPool) -> None:
        with pool.batch() as run:
            with pytest.raises(BusyError), pool.batch():
                pass
            await asyncio.gather(*(run(0.0, _wanted) for _ in range(20)))
        with pool.batch():
            pass

    _with_pool(time.sleep, use, queue_size=0)


def test_a_caller_that_is_cancelled_while_it_is_asked_keeps_no_worker() -> None:
    async def use(pool: WorkerPool) -> None:
        asked = asyncio.Event()

        async def unsure() -> bool:
            asked.set()
            await asyncio.sleep(60)
            return False

        with pool.batch() as run:
            for way in (run, pool.run):
                asked.clear()
                busy = asyncio.create_task(pool.run(0.1, _wanted))
                await asyncio.sleep(0.0)
                task = asyncio.create_task(way(0.0, unsure))
                await asked.wait()
                task.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await task
                await busy
            assert await asyncio.wait_for(run(0.0, _wanted), 30) is None

    _with_pool(time.sleep, use)
