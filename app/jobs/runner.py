"""What a service does with jobs: it takes one after the other, and those of services that went silent."""

import asyncio
import logging
from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import aclosing
from typing import Any

import orjson

from ..engine import items
from ..wire.problems import (
    BusyError,
    InsufficientStorageError,
    JobsUnavailableError,
    ServiceError,
    WorkerDiedError,
    problem,
)
from ..workers import logs
from ..workers.request_id import REQUEST_ID
from .desk import Desk
from .files import JobFiles, Line
from .record import FAILED, SUCCESSFUL, Job, Progress
from .store import told
from .watch import Watch

ROUND = 0.5
"""Seconds between two signs of life, in which lines are kept together, and between two looks for work."""
_LONGEST_PAUSE = 2.0
"""Seconds between two tries, at most, while a disk or a database refuses: less than it takes to mend one."""
_CLEANING = 60.0
_AHEAD = 8 * 1024 * 1024
"""Bytes of lines that may be made before the disk takes them."""
_STOPPING = 5.0
"""Seconds to let go of the jobs when the service stops; after them their leases end by themselves."""
_PAUSES = (JobsUnavailableError, InsufficientStorageError)
_log = logging.getLogger("primfit")

Work = Callable[[Job, JobFiles, Sequence[items.Told]], AsyncGenerator[Line, None]]
"""Makes the lines of a job behind those that are told; it is closed where the job is somebody else's."""


class JobRefusedError(Exception):
    """A job that cannot be done, with the problem document that says why."""

    def __init__(self, document: bytes) -> None:
        super().__init__("the job is refused")
        self.document: dict[str, Any] = orjson.loads(document)


class Runner:
    """Begins at most so many jobs at once, until it is stopped or `stopping` says so.

    Those of services that ended come beside them: who has waited for a turn does not wait for another one.
    """

    def __init__(self, desk: Desk, work: Work, at_once: int, stopping: Callable[[], bool]) -> None:
        self._desk, self._work, self._at_once = desk, work, at_once
        self._stopping, self._stopped = stopping, asyncio.Event()
        self._watch = Watch()
        self._attempts: dict[str, asyncio.Task[None]] = {}
        self._complaint = _Complaint()
        self._cleaned: float | None = None
        self._task: asyncio.Task[None] | None = None

    def start(self) -> None:
        self._task = asyncio.create_task(self._run())

    async def stop(self) -> None:
        """Leave the jobs to others at once."""
        self._stopped.set()
        if self._task is not None:
            done, _ = await asyncio.wait({self._task}, timeout=_STOPPING)
            for task in () if done else (self._task, *self._attempts.values()):
                task.cancel()

    def _ends(self) -> bool:
        return self._stopped.is_set() or self._stopping()

    async def _run(self) -> None:
        REQUEST_ID.set(None)
        pause = ROUND
        while not self._ends():
            try:
                pause = 0.0 if await self._begin() else ROUND
                await self._clean()
                self._complaint.over()
            except Exception as error:
                self._complaint.about(error)
                pause = min(2 * max(pause, ROUND), _LONGEST_PAUSE)
            await self._sleep(pause)
        if self._attempts:
            await asyncio.wait(self._attempts.values())

    async def _sleep(self, seconds: float) -> None:
        try:
            async with asyncio.timeout(seconds):
                await self._stopped.wait()
        except TimeoutError:
            pass

    async def _begin(self) -> bool:
        """Begin a job if there is one and room for it; one that was begun elsewhere needs none."""
        full = len(self._attempts) >= self._at_once
        job = await self._orphaned() or await self._desk.call(self._desk.store.claim, full)
        if job is None:
            return False
        attempt = Attempt(self._desk, job, self._work, self._ends)
        task = asyncio.create_task(attempt.run())
        self._attempts[job.id] = task
        task.add_done_callback(lambda _: self._attempts.pop(job.id, None))
        return True

    async def _orphaned(self) -> Job | None:
        """A job whose service went silent, now ours."""
        beats = await self._desk.call(self._desk.store.beats)
        for beat in self._watch.silent([beat for beat in beats if beat.job_id not in self._attempts]):
            crashed = problem(
                WorkerDiedError("services ended again and again while they worked on one line of this job"),
                f"/jobs/{beat.job_id}",
            )
            job = await self._desk.call(self._desk.take_over, beat, orjson.loads(crashed.content))
            if job is not None:
                return job
        return None

    async def _clean(self) -> None:
        now = asyncio.get_running_loop().time()
        if self._cleaned is None or now - self._cleaned > _CLEANING:
            n_removed = await self._desk.call(self._desk.clean)
            self._cleaned = now
            if n_removed:
                logs.event(_log, logging.INFO, "old jobs are removed", {"jobs": n_removed})


class Attempt:
    """Work on one job, until it has ended or is somebody else's.

    Two things go on side by side: lines are made, and every `ROUND` those that are there are written, then
    counted in the record. This is the sign of life, too, and tells whether the job is still this attempt's.
    """

    def __init__(self, desk: Desk, job: Job, work: Work, leaving: Callable[[], bool]) -> None:
        self._desk, self._job, self._work, self._leaving = desk, job, work, leaving
        self._files = desk.folder.of(job.id)
        self._results = self._files.appender(job.attempt)
        self._progress, self._beat = job.progress, 0
        self._told: list[items.Told] = []
        self._lines: list[Line] = []
        self._summary: dict[str, int] | None = None
        self._room = asyncio.Event()
        self._complaint, self._waiting = _Complaint(), _Complaint()

    async def run(self) -> None:
        REQUEST_ID.set(self._job.request.get("request_id"))
        self._log("a job is begun", lines=self._progress.lines)
        maker = asyncio.create_task(self._make())
        try:
            held = True
            while held:
                await asyncio.wait({maker}, timeout=ROUND)
                held = await self._note(maker)
                if held and maker.done():  # and the disk or the database refuses its end
                    await asyncio.sleep(ROUND)
        except Exception:
            _log.exception("a job is given up; another attempt follows")
        finally:
            maker.cancel()
            await asyncio.wait({maker})

    async def _make(self) -> None:
        """Every line from the first that is not told.

        What the machine refuses for now is waited for: a job fails for that only where its files are lost.
        """
        before = self._progress.parts
        told: list[items.Told] | None = None
        while True:
            try:
                if told is None:
                    told = self._told = await self._desk.call(self._files.told, before)
                async with aclosing(self._work(self._job, self._files, tuple(self._told))) as lines:
                    async for line in lines:
                        await self._take(line)
                return
            except (BusyError, InsufficientStorageError, OSError) as error:
                if await self._desk.call(self._files.are_lost, before):
                    raise
                self._waiting.about(error)
                await asyncio.sleep(_LONGEST_PAUSE)

    async def _take(self, line: Line) -> None:
        self._waiting.over()
        told, content = line
        if told is None:
            self._summary = orjson.loads(content)["summary"]
        else:
            self._told.append(told)
        self._lines.append(line)
        while sum(len(content) for _, content in self._lines) > _AHEAD:
            self._room.clear()
            await self._room.wait()

    async def _note(self, maker: asyncio.Task[None]) -> bool:
        """Keep what there is; whether the job is still ours, and not ended."""
        made, leaving = maker.done(), self._leaving()  # asked first: then its lines are all there
        try:
            written = await self._write()
            if made and written and not (leaving and maker.exception()):
                await self._end(maker.exception())
                return False
            call, store = self._desk.call, self._desk.store
            if leaving:
                if await call(store.release, self._job, self._progress):
                    self._log("a job is left to others", lines=self._progress.lines)
                return False
            self._beat += 1
            held = await call(store.keep, self._job, self._beat, self._progress)
            if written:
                self._complaint.over()
            if not held:
                self._log("a job was canceled, or others go on with it", lines=self._progress.lines)
            return held
        except _PAUSES as error:
            self._complaint.about(error)
            return not leaving

    async def _write(self) -> bool:
        """The lines that are there; whether the disk took them."""
        lines = list(self._lines)
        if not lines:
            return True
        try:
            part = await self._desk.call(self._results.append, lines)
        except (InsufficientStorageError, OSError) as error:
            self._complaint.about(error)
            return False
        del self._lines[: len(lines)]
        self._room.set()
        before = self._job.progress
        self._progress = Progress(
            (*before.parts, part),
            before.lines + part.lines,
            self._percent(next((told for told, _ in reversed(lines) if told is not None), None)),
        )
        return True

    def _percent(self, told: items.Told | None) -> int:
        """The share that is done: files count alike, and so do the items of one file."""
        if told is None:
            return self._progress.percent
        done = told.file - 1 + (told.index + 1) / told.of
        return min(99, int(100 * done / self._job.n_files))

    async def _end(self, error: BaseException | None) -> None:
        status, summary, document = SUCCESSFUL, None, None
        if error is None:
            self._progress = Progress(self._progress.parts, self._progress.lines, 100)
            summary = self._summary
        else:
            status, document = FAILED, self._document(error)
        if await self._desk.call(self._desk.store.end, self._job, self._progress, status, summary, document):
            await self._desk.call(self._files.remove_body)
            self._log("a job has ended", status=status, lines=self._progress.lines)

    def _document(self, error: BaseException) -> dict[str, Any]:
        if isinstance(error, JobRefusedError):
            return error.document
        assert isinstance(error, Exception)
        made = problem(error, f"/jobs/{self._job.id}")
        if made.status >= 500:
            _log.error("a job failed", exc_info=error)
        document: dict[str, Any] = orjson.loads(made.content)
        return document

    def _log(self, message: str, **facts: Any) -> None:
        logs.event(
            _log, logging.INFO, message, {"job": self._job.id, "client": self._job.owner or None} | facts
        )


class _Complaint:
    """What hinders the work: told once, until it is over."""

    def __init__(self) -> None:
        self._told = False

    def about(self, error: Exception) -> None:
        if not self._told:
            unforeseen = not isinstance(error, ServiceError | OSError)
            _log.warning(
                "%s; jobs wait, and go on when this is over",
                told(error),
                exc_info=error if unforeseen else None,
            )
        self._told = True

    def over(self) -> None:
        self._told = False
