"""What is sent of a job over time: pages of its results, and its events."""

import asyncio
from collections.abc import AsyncGenerator, Callable
from contextlib import suppress
from typing import Any

import orjson
from starlette.requests import ClientDisconnect

from ..jobs.desk import Desk
from ..jobs.record import Job
from ..wire.problems import JobsUnavailableError, NoSuchJobError
from ..workers.batch_jobs import Stretch

_PIECE = 256 * 1024
_LOOK = 1.0
"""Seconds between two looks at a job for its events."""
HEARTBEAT = 15.0
"""Seconds after which a comment tells proxies and clients that the connection lives."""
_LINES = 100
"""Lines that are read at once for events."""
END = "end"
"""The id of the last event: whoever names it has seen all."""


async def pieces(desk: Desk, stretches: list[Stretch]) -> AsyncGenerator[bytes, None]:
    """The bytes of some stretches, in pieces that memory holds.

    Raises
    ------
    ClientDisconnect
        The job was removed meanwhile: the connection ends before the answer is whole.
    """
    for stretch in stretches:
        for start in range(stretch.start, stretch.stop, _PIECE):
            piece = Stretch(stretch.path, start, min(start + _PIECE, stretch.stop))
            try:
                content = await desk.call(piece.read)
            except FileNotFoundError:
                raise ClientDisconnect from None
            yield content


class Events:
    """The events of a job: its status whenever it changes, and each line of its results once."""

    def __init__(
        self,
        desk: Desk,
        job: Job,
        shown: Callable[[Job], Any],
        stopping: Callable[[], bool],
    ) -> None:
        """`shown` makes the document of a job; the stream ends, to go on elsewhere, when `stopping`."""
        self._desk, self._job, self._shown, self._stopping = desk, job, shown, stopping

    async def stream(self, n_seen: int) -> AsyncGenerator[bytes, None]:
        """Events behind the first lines, as they come; the last one tells how the job has ended."""
        job, told, silent = self._job, b"", 0.0
        yield b"retry: 2000\n\n"
        while not self._stopping():
            try:
                document = orjson.dumps(await self._shown(job))
            except JobsUnavailableError:
                await asyncio.sleep(_LOOK)
                continue
            if document != told and not job.ended:
                yield _event("status", document)
                told, silent = document, 0.0
            while n_seen < job.progress.lines:
                try:
                    lines = await self._lines(job, n_seen)
                except FileNotFoundError:
                    if job.ended and await self._is_kept(job):  # its results were deleted by hand
                        break
                    return
                for line in lines:
                    n_seen += 1
                    yield _event("result", line, str(n_seen))
                silent = 0.0
            if job.ended:
                yield _event("status", document, END)
                return
            await asyncio.sleep(_LOOK)
            silent += _LOOK
            if silent >= HEARTBEAT:
                yield b": still here\n\n"
                silent = 0.0
            try:
                job = await self._desk.find(job.id, job.owner)
            except JobsUnavailableError:
                continue
            except NoSuchJobError:  # removed meanwhile
                return

    async def _is_kept(self, job: Job) -> bool:
        with suppress(NoSuchJobError):
            return bool(await self._desk.find(job.id, job.owner))
        return False

    async def _lines(self, job: Job, offset: int) -> list[bytes]:
        files = self._desk.folder.of(job.id)
        stretches = await self._desk.call(files.page, job.progress.parts, offset, _LINES)
        content = b"".join([await self._desk.call(stretch.read) for stretch in stretches])
        return content.splitlines()


def _event(name: str, data: bytes, event_id: str | None = None) -> bytes:
    head = f"event: {name}\n" + ("" if event_id is None else f"id: {event_id}\n")
    return head.encode() + b"data: " + data + b"\n\n"
