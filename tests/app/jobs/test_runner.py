"""What a service does with jobs, with quick work: each line once, whoever stops, stalls or takes over."""

import asyncio
import errno
import json
import random
from collections.abc import AsyncGenerator, Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from primfit.app.engine.items import Told
from primfit.app.jobs import runner as runners
from primfit.app.jobs import watch
from primfit.app.jobs.clock import SteadyClock
from primfit.app.jobs.desk import Desk
from primfit.app.jobs.files import Folder, JobFiles, Line
from primfit.app.jobs.record import Job
from primfit.app.jobs.runner import JobRefusedError, Runner
from primfit.app.jobs.store import Store, sqlite_url
from primfit.app.wire.problems import InsufficientStorageError
from tests.app.jobs.making import MANY, new

N = 40
LIMIT = 60.0


def _content(k: int) -> bytes:
    return json.dumps({"id": f"item {k}", "label": k}).encode() + b"\n"


ALL = b"".join(map(_content, range(N))) + b'{"summary":{"items":%d}}\n' % N


async def counting(job: Job, files: JobFiles, told: Sequence[Told]) -> AsyncGenerator[Line, None]:
    """The lines of a job of one file with `N` segments, some of them in no time and some in more."""
    for k in range(len(told), N):
        await asyncio.sleep(random.Random(k).choice([0.0, 0.0, 0.02]))
        yield Told(1, k, N, "fitted", k), _content(k)
    yield None, ALL[-len(b'{"summary":{"items":%d}}\n' % N) :]


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """A tenth of the times of a service."""
    monkeypatch.setattr(runners, "ROUND", 0.05)
    monkeypatch.setattr(runners, "_LONGEST_PAUSE", 0.2)
    monkeypatch.setattr(watch, "PATIENCE", 0.5)


@contextmanager
def desks(path: Path, number: int = 1, clock: SteadyClock | None = None) -> Iterator[list[Desk]]:
    """Those of services that share a folder."""
    folder = Folder(path)
    made = [
        Desk(Store(sqlite_url(path), clock or SteadyClock(), 60.0), folder, 9, MANY) for _ in range(number)
    ]
    yield made
    for desk in made:
        desk.close()


def _runner(desk: Desk, work: Any = counting, stopping: Callable[[], bool] = lambda: False) -> Runner:
    runner = Runner(desk, work, 2, stopping)
    runner.start()
    return runner


async def _ended(desk: Desk, job_id: str) -> Job:
    async with asyncio.timeout(LIMIT):
        while True:
            job = await desk.find(job_id, "alice")
            if job.ended:
                return job
            await asyncio.sleep(0.02)


async def _some_lines(desk: Desk, job_id: str) -> Job:
    async with asyncio.timeout(LIMIT):
        while not (job := await desk.find(job_id, "alice")).progress.lines:
            await asyncio.sleep(0.01)
    return job


async def _results(desk: Desk, job: Job) -> bytes:
    pages = desk.folder.of(job.id).page(job.progress.parts, 0, MANY)
    return b"".join(page.read() for page in pages)


async def _crash(runner: Runner) -> None:
    """End it as SIGKILL would: nothing is said, nothing is released."""
    attempts = list(runner._attempts.values())
    assert runner._task is not None
    for task in (runner._task, *attempts):
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


def test_a_job_is_done_and_its_body_removed(tmp_path: Path) -> None:
    async def check() -> None:
        with desks(tmp_path) as (desk,):
            kept = await desk.submit(new(), b"body")
            runner = _runner(desk)
            job = await _ended(desk, kept.id)
            assert (job.status, job.progress.percent, job.summary) == ("successful", 100, {"items": N})
            assert await _results(desk, job) == ALL
            await runner.stop()
            assert not desk.folder.of(job.id).body.exists()
            assert job.bytes == len(ALL)

    asyncio.run(check())


def test_a_job_of_a_service_that_crashed_is_resumed_by_another(tmp_path: Path) -> None:
    begun_at: list[int] = []

    async def work(job: Job, files: JobFiles, told: Sequence[Told]) -> AsyncGenerator[Line, None]:
        begun_at.append(len(told))
        async for line in counting(job, files, told):
            yield line

    async def check() -> None:
        with desks(tmp_path, 2) as (desk, other):
            kept = await desk.submit(new(), b"body")
            first = _runner(desk, work)
            await _some_lines(desk, kept.id)
            await _crash(first)
            second = _runner(other, work)
            job = await _ended(other, kept.id)
            assert await _results(other, job) == ALL
            assert len(begun_at) == 2 and begun_at[1] > 0
            await second.stop()

    asyncio.run(check())


def test_a_service_that_stops_leaves_its_job_to_another_at_once(tmp_path: Path) -> None:
    async def check() -> None:
        with desks(tmp_path, 2) as (desk, other):
            kept = await desk.submit(new(), b"body")
            first = _runner(desk)
            await _some_lines(desk, kept.id)
            await first.stop()
            left = await desk.find(kept.id, "alice")
            assert left.status == "accepted" and left.progress.lines > 0
            second = _runner(other)
            assert await _results(other, await _ended(other, kept.id)) == ALL
            await second.stop()

    asyncio.run(check())


def test_a_job_that_was_begun_elsewhere_waits_for_no_room(tmp_path: Path) -> None:
    async def endless(job: Job, files: JobFiles, told: Sequence[Told]) -> AsyncGenerator[Line, None]:
        yield Told(1, len(told), MANY, "fitted", 0), _content(0)
        await asyncio.sleep(MANY)

    async def check() -> None:
        with desks(tmp_path, 2) as (desk, other):
            mine = [await desk.submit(new(), b"body") for _ in range(2)]
            first = _runner(desk, endless)
            for kept in mine:
                await _some_lines(desk, kept.id)
            theirs = [await other.submit(new(), b"body") for _ in range(3)]
            second = _runner(other, endless)
            for kept in theirs[:2]:
                await _some_lines(other, kept.id)
            await first.stop()
            for kept in mine:
                async with asyncio.timeout(LIMIT):
                    while (await other.find(kept.id, "alice")).progress.lines < 2:
                        await asyncio.sleep(0.02)
            assert (await other.find(theirs[2].id, "alice")).status == "accepted"
            await second.stop()

    asyncio.run(check())


def test_two_services_that_both_believe_the_job_is_theirs_tell_each_line_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def check() -> None:
        with desks(tmp_path, 2) as (desk, other):
            kept = await desk.submit(new(), b"body")
            keep, stalled = desk.store.keep, asyncio.Event()

            def stalls(*args: Any) -> bool:  # as a process that is stopped, and goes on later
                if args[2].lines:
                    loop.call_soon_threadsafe(stalled.set)
                    while other.store.find(kept.id).attempt == 1:  # type: ignore[union-attr]
                        pass
                return keep(*args)

            loop = asyncio.get_running_loop()
            monkeypatch.setattr(desk.store, "keep", stalls)
            first = _runner(desk)
            await stalled.wait()
            second = _runner(other)
            job = await _ended(other, kept.id)
            assert job.attempt == 2
            assert await _results(other, job) == ALL
            await first.stop()
            await second.stop()

    asyncio.run(check())


def test_clocks_that_jump_lose_and_double_nothing(tmp_path: Path) -> None:
    wall = 1e9
    steady = SteadyClock(lambda: wall)

    async def check() -> None:
        nonlocal wall
        with desks(tmp_path, 2, steady) as (desk, other):
            kept = [await desk.submit(new(), b"body") for _ in range(4)]
            runners = [_runner(desk), _runner(other)]
            for jump in (1e6, -3e6, 1e9, -1e9):
                await asyncio.sleep(0.05)
                wall += jump
            for each in kept:
                job = await _ended(desk, each.id)
                assert await _results(desk, job) == ALL
                assert job.attempt == 1  # nobody took anything for dead
            for runner in runners:
                await runner.stop()

    asyncio.run(check())


def test_a_job_waits_for_a_full_disk_and_a_database_that_is_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """The two that refuse are real elsewhere: here they refuse at every second call."""
    from primfit.app.jobs.files import Appender
    from primfit.app.wire.problems import JobsUnavailableError

    calls = {"append": 0, "keep": 0}

    def refusing(name: str, whole: Any, error: Exception) -> Any:
        def sometimes(*args: Any) -> Any:
            calls[name] += 1
            if calls[name] % 2:
                raise error
            return whole(*args)

        return sometimes

    async def check() -> None:
        with desks(tmp_path) as (desk,):
            kept = await desk.submit(new(), b"body")
            gone = JobsUnavailableError("gone")
            monkeypatch.setattr(desk.store, "keep", refusing("keep", desk.store.keep, gone))
            full = InsufficientStorageError("full")
            monkeypatch.setattr(Appender, "append", refusing("append", Appender.append, full))
            runner = _runner(desk)
            job = await _ended(desk, kept.id)
            assert (job.status, await _results(desk, job)) == ("successful", ALL)
            await runner.stop()

    asyncio.run(check())
    assert min(calls.values()) > 1
    assert "jobs wait" in caplog.text


@pytest.mark.parametrize(
    "error", [OSError(errno.EMFILE, "Too many open files"), FileNotFoundError("temporary"), PermissionError()]
)
def test_what_the_machine_refuses_for_now_fails_no_job(
    tmp_path: Path, error: OSError, caplog: pytest.LogCaptureFixture
) -> None:
    begun_at: list[int] = []

    async def work(job: Job, files: JobFiles, told: Sequence[Told]) -> AsyncGenerator[Line, None]:
        begun_at.append(len(told))
        if len(begun_at) < 3:
            raise error
        async for line in counting(job, files, told):
            yield line
            if len(begun_at) == 3:
                raise error

    async def check() -> None:
        with desks(tmp_path) as (desk,):
            kept = await desk.submit(new(), b"body")
            runner = _runner(desk, work)
            job = await _ended(desk, kept.id)
            assert (job.status, await _results(desk, job)) == ("successful", ALL)
            await runner.stop()

    asyncio.run(check())
    assert begun_at == [0, 0, 0, 1]
    assert caplog.text.count("jobs wait") == 2  # once before a line came, once behind it


def test_what_hinders_the_search_for_jobs_is_told_once_with_its_reason(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "jobs.sqlite").write_bytes(b"no database" * 100)

    async def check() -> None:
        with desks(tmp_path) as (desk,):
            runner = _runner(desk)
            await asyncio.sleep(1.0)  # some rounds
            await runner.stop()

    asyncio.run(check())
    assert caplog.text.count("the database of the jobs does not answer") == 1
    assert "(file is not a database)" in caplog.text and "Traceback" not in caplog.text


def test_a_job_that_breaks_services_leaves_no_body(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("primfit.app.jobs.store.MOST_CRASHES", 1)
    with desks(tmp_path) as (desk,):
        kept = asyncio.run(desk.submit(new(), b"body"))
        desk.store.claim()
        (silent,) = desk.store.beats()
        assert desk.take_over(silent, {}) is None
        assert desk.store.find(kept.id).status == "failed"  # type: ignore[union-attr]
        assert desk.folder.ids() == {kept.id} and not desk.folder.of(kept.id).body.exists()


def test_a_job_whose_body_is_lost_fails(tmp_path: Path) -> None:
    async def work(job: Job, files: JobFiles, told: Sequence[Told]) -> AsyncGenerator[Line, None]:
        files.body.read_bytes()
        yield None, ALL

    async def check() -> None:
        with desks(tmp_path) as (desk,):
            kept = await desk.submit(new(), b"body")
            desk.folder.of(kept.id).remove_body()
            runner = _runner(desk, work)
            assert (await _ended(desk, kept.id)).status == "failed"
            await runner.stop()

    asyncio.run(check())


def test_a_job_that_cannot_be_done_fails_and_says_why(tmp_path: Path) -> None:
    async def refused(job: Job, files: JobFiles, told: Sequence[Told]) -> AsyncGenerator[Line, None]:
        raise JobRefusedError(b'{"title":"no"}')
        yield

    async def broken(job: Job, files: JobFiles, told: Sequence[Told]) -> AsyncGenerator[Line, None]:
        yield Told(1, 0, N, "fitted", 0), _content(0)
        raise RuntimeError("secret")

    async def check() -> None:
        for work, title, lines in ((refused, "no", 0), (broken, "The service failed", 1)):
            with desks(tmp_path / title) as (desk,):
                kept = await desk.submit(new(), b"body")
                runner = _runner(desk, work)
                job = await _ended(desk, kept.id)
                assert (job.status, job.progress.lines) == ("failed", lines)
                assert str(job.problem["title"]).startswith(title)  # type: ignore[index]
                assert "secret" not in str(job.problem)
                await runner.stop()

    asyncio.run(check())


def test_a_job_that_is_canceled_ends_its_work(tmp_path: Path) -> None:
    ended = asyncio.Event()

    async def endless(job: Job, files: JobFiles, told: Sequence[Told]) -> AsyncGenerator[Line, None]:
        try:
            for k in range(10**9):
                await asyncio.sleep(0.01)
                yield Told(1, k, 10**9, "fitted", k), _content(k)
        finally:
            ended.set()

    async def check() -> None:
        with desks(tmp_path) as (desk,):
            kept = await desk.submit(new(), b"body")
            runner = _runner(desk, endless)
            await _some_lines(desk, kept.id)
            await desk.call(desk.dismiss, kept)
            async with asyncio.timeout(LIMIT):
                await ended.wait()
            job = await desk.find(kept.id, "alice")
            assert job.status == "dismissed" and job.progress.lines > 0
            await desk.call(desk.dismiss, job)
            assert desk.folder.ids() == set()
            await runner.stop()

    asyncio.run(check())


def test_jobs_whose_time_has_come_are_removed(tmp_path: Path) -> None:
    now = 0.0

    async def check() -> None:
        nonlocal now
        with desks(tmp_path, 1, SteadyClock(lambda: 0.0, lambda: now)) as (desk,):
            kept = await desk.submit(new(), b"body")
            await desk.call(desk.dismiss, kept)
            now += 61.0
            runner = _runner(desk)
            async with asyncio.timeout(LIMIT):
                while desk.store.ids():
                    await asyncio.sleep(0.02)
            assert not desk.folder.ids()
            await runner.stop()

    asyncio.run(check())
