"""The pool by itself: jobs of the standard library stand for fits that hang, crash or succeed."""

import asyncio
import math
import os
import socket
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from primfit.app.wire.problems import BusyError, TimeLimitError, WorkerDiedError
from primfit.app.workers.pipe import TAKEN, packed
from primfit.app.workers.pool import WorkerPool
from tests.app.processes import needs_proc
from tests.app.serving import PATIENCE, wait_for


async def _wanted() -> bool:
    return False


async def _abandoned() -> bool:
    return True


def _with_pool(
    work: Callable[[Any], Any], use: Callable[[WorkerPool], Awaitable[None]], size: int = 1, **options: Any
) -> None:
    """Run `use` with a pool of workers that do `work`."""

    async def run() -> None:
        pool = WorkerPool(size, os.getpid, work, **options)
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
        await _until(lambda: pool.n_waiting["small"] == 1)
        with pytest.raises(BusyError):
            await pool.run(free, _wanted)
        await asyncio.to_thread(held.write_bytes, b"go on")
        assert await asyncio.gather(busy, waiting) == [b"go on", b""]
        assert (pool.n_busy, pool.n_waiting["small"], pool.n_restarts) == (0, 0, 0)

    _with_pool(Path.read_bytes, use, queue_size=1)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="holds a worker up with a named pipe")
def test_small_clouds_are_taken_however_many_large_ones_wait(tmp_path: Path) -> None:
    """While a worker is free for them, and when none is."""
    fifos = [tmp_path / name for name in ("large", "larger", "small", "smaller")]
    for fifo in fifos:
        os.mkfifo(fifo)

    async def use(pool: WorkerPool) -> None:
        await _until(lambda: pool.n_warm == 2)
        large = [asyncio.create_task(pool.run(fifo, _wanted, large=True)) for fifo in fifos[:2]]
        await _until(lambda: pool.n_busy == 1 and pool.n_waiting["large"] == 1)
        with pytest.raises(BusyError, match="1 requests with large clouds are waiting"):
            pool.check_room(large=True)
        small = [asyncio.create_task(pool.run(fifo, _wanted)) for fifo in fifos[2:]]
        await _until(lambda: pool.n_busy == 2 and pool.n_waiting["small"] == 1)
        with pytest.raises(BusyError, match="1 requests with small clouds are waiting"):
            pool.check_room(large=False)
        # Whichever is read first.
        await asyncio.gather(*(asyncio.to_thread(fifo.write_bytes, b"go on") for fifo in fifos))
        assert await asyncio.gather(*large, *small) == [b"go on"] * 4

    _with_pool(Path.read_bytes, use, size=2, queue_size=1)


WORKER = """
import os, pathlib, socket, sys
from primfit.app.workers.worker import serve
serve(socket.socket(fileno=int(sys.argv[1])), os.getpid, bytes, pathlib.Path(sys.argv[2]))
"""


@pytest.mark.skipif(os.name != "posix", reason="hands a socket to another process")
def test_files_go_with_a_service_that_dies_with_an_answer_on_its_way(tmp_path: Path) -> None:
    """The worker sends to nobody, and hears that what it sent was thrown away."""
    for number in range(2000):
        (tmp_path / f"primfit-7-{number}").touch()
    ours, theirs = socket.socketpair()
    command = [sys.executable, "-c", WORKER, str(theirs.fileno()), str(tmp_path / "primfit-7-*")]
    with subprocess.Popen(command, pass_fds=[theirs.fileno()]), ours:
        theirs.close()
        assert ours.recv(1) == TAKEN
        ours.sendall(packed(10_000_000))
        ours.recv(1)
    assert not list(tmp_path.iterdir())


def test_an_abandoned_job_is_not_begun() -> None:
    async def use(pool: WorkerPool) -> None:
        busy = asyncio.create_task(pool.run(1.0, _wanted))
        await _until(lambda: pool.n_busy == 1)
        assert await pool.run(60.0, _abandoned) is None
        await busy
        assert (pool.n_warm, pool.n_restarts) == (1, 0)

    _with_pool(time.sleep, use)


def test_the_work_for_a_client_that_left_is_ended() -> None:
    async def use(pool: WorkerPool) -> None:
        await pool.run(0.0, _wanted)
        assert await pool.run(PATIENCE, _abandoned) is None
        await asyncio.wait_for(pool.run(0.0, _wanted), PATIENCE / 2)
        assert pool.n_restarts == 1

    _with_pool(time.sleep, use)


def test_work_that_ends_in_a_moment_costs_no_process_when_its_client_leaves() -> None:
    async def use(pool: WorkerPool) -> None:
        await pool.run(0.0, _wanted)
        assert await pool.run(0.4, _abandoned) is None
        await pool.run(0.0, _wanted)
        assert pool.n_restarts == 0

    _with_pool(time.sleep, use)


def test_the_time_in_the_queue_counts() -> None:
    async def use(pool: WorkerPool) -> None:
        busy = asyncio.create_task(pool.run(3.0, _wanted))
        await _until(lambda: pool.n_busy == 1)
        with pytest.raises(BusyError, match=r"within 0\.5 s; it was not begun"):
            await pool.run(0.0, _wanted, patience=0.5)
        await busy
        with pytest.raises(TimeLimitError, match=r"0\.5 s"):
            await pool.run(PATIENCE, _wanted, patience=0.5)

    _with_pool(time.sleep, use)


def test_a_request_whose_turn_would_come_too_late_is_refused_at_once_and_told_when() -> None:
    async def use(pool: WorkerPool) -> None:
        await pool.run(1.5, _wanted)
        busy = [asyncio.create_task(pool.run(1.5, _wanted)) for _ in range(3)]
        await _until(lambda: pool.n_waiting["small"] == 2)
        with pytest.raises(BusyError) as refused:
            await pool.run(0.0, _wanted, patience=3.0)
        assert refused.value.headers == {"Retry-After": "5"}
        for task in busy:
            task.cancel()

    _with_pool(time.sleep, use)


def test_work_that_would_be_cut_off_is_not_begun() -> None:
    """The one ahead takes three times as long as expected, which leaves less time than work takes."""

    async def use(pool: WorkerPool) -> None:
        await pool.run(0.5, _wanted)
        ahead = asyncio.ensure_future(pool.run(1.5, _wanted))
        await asyncio.sleep(0)
        with pytest.raises(BusyError):
            await pool.run(0.5, _wanted, patience=1.75)
        await ahead
        assert pool.n_restarts == 0

    _with_pool(time.sleep, use)


def test_large_ones_leave_a_worker_to_small_ones() -> None:
    async def use(pool: WorkerPool) -> None:
        await _until(lambda: pool.n_warm == 2)
        large = [asyncio.create_task(pool.run(PATIENCE, _wanted, large=True)) for _ in range(3)]
        await _until(lambda: pool.n_busy == 1 and pool.n_waiting["large"] == 2)
        assert await pool.run(0.0, _wanted) is None
        assert pool.n_busy == 1
        for task in large:
            task.cancel()

    _with_pool(time.sleep, use, size=2)


def test_large_items_of_a_batch_do_not_hold_up_small_ones_of_another() -> None:
    async def use(pool: WorkerPool) -> None:
        await _until(lambda: pool.n_warm == 2)
        with pool.batch() as first, pool.batch() as second:
            large = [asyncio.create_task(first(PATIENCE, _wanted, heavy=True)) for _ in range(4)]
            await _until(lambda: pool.n_busy == 1 and pool.n_waiting["batches"] == 3)
            small = asyncio.gather(*(second(0.0, _wanted) for _ in range(9)))
            await asyncio.wait_for(small, PATIENCE / 2)
            assert pool.n_busy == 1
            for task in large:
                task.cancel()

    _with_pool(time.sleep, use, size=2)


@needs_proc
def test_a_worker_ends_with_its_service_and_takes_the_temporary_files_along(tmp_path: Path) -> None:
    """Also in the middle of a job; the service is killed, so that it can do nothing."""
    for name in ("mine-1", "mine-2", "other"):
        (tmp_path / name).touch()
    script = f"""
import asyncio, os, time
from pathlib import Path
from primfit.app.workers.pool import WorkerPool

async def wanted():
    return False

async def main():
    pool = WorkerPool(1, os.getpid, time.sleep, litter=Path({str(tmp_path)!r}, "mine-*"))
    pool.start()
    await pool.run(0.0, wanted)
    print(pool.greeting, flush=True)
    await pool.run(60.0, wanted)

asyncio.run(main())
"""
    service = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE)
    assert service.stdout is not None
    worker = int(service.stdout.readline())
    service.kill()
    service.wait()
    service.stdout.close()
    wait_for(lambda: not Path(f"/proc/{worker}").exists(), 10.0)
    assert [file.name for file in tmp_path.iterdir()] == ["other"]


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
                busy = asyncio.create_task(pool.run(1.0, _wanted))
                await asyncio.sleep(0.0)
                task = asyncio.create_task(way(0.0, unsure))
                await asyncio.wait_for(asked.wait(), PATIENCE)
                task.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await task
                await busy
            assert await asyncio.wait_for(run(0.0, _wanted), 30) is None

    _with_pool(time.sleep, use)
