"""The lines of a job, made as those of a batch, and what a job is at its beginning."""

import asyncio
import uuid
from collections.abc import AsyncGenerator, Awaitable, Callable, Iterator, Sequence
from contextlib import AsyncExitStack, aclosing
from hashlib import sha256
from pathlib import Path
from typing import Any

import orjson
from starlette.requests import ClientDisconnect

from ..engine.items import Told
from ..jobs.files import JobFiles, Line
from ..jobs.record import Job, NewJob
from ..jobs.runner import JobRefusedError
from ..wire.problems import KINDS, InsufficientStorageError, WorkerDiedError
from ..workers.batch_jobs import Opened, OpenJob, Stretch
from ..workers.cluster import Cluster
from ..workers.jobs import Reply
from ..workers.pool import Run, WorkerPool
from .batch_stream import Batch
from .body import is_large, size
from .metrics import Metrics
from .settings import Settings
from .spool import Spool

_TRIES = 3
"""Workers that may end over an item before this is the answer for it."""
_NO_SPACE = KINDS[InsufficientStorageError].slug
_PIECE = 1 << 20
_GONE = "files that a worker needs are gone"


class JobWork:
    """Does jobs by the pool of workers of this service, where they take turns with its requests, or on a
    cluster."""

    def __init__(
        self,
        pool: WorkerPool | Cluster,
        spool: Spool,
        settings: Callable[[], Settings],
        metrics: Metrics,
    ) -> None:
        """`settings` tells those that are in force when a job is begun: they may change while it waits."""
        self._pool, self._spool, self._settings, self._metrics = pool, spool, settings, metrics

    async def __call__(self, job: Job, files: JobFiles, told: Sequence[Told]) -> AsyncGenerator[Line, None]:
        """Its lines behind those that are told.

        Raises
        ------
        JobRefusedError
            The body is not opened any more.
        InsufficientStorageError, BusyError
            There is no room now for temporary files, or for one more batch.
        FileNotFoundError
            The body, or a temporary file, is gone.
        ClusterLostError
            There is no cluster now.
        """
        settings = self._settings()
        n_workers, spool = await self._room(job, files)
        async with AsyncExitStack() as resources:
            run = _steady(resources.enter_context(self._pool.batch()))
            coding = job.request["coding"]
            unpacked = Path(resources.enter_context(spool.file()).name) if coding else None
            opening = open_job(job.request, files.body, unpacked, settings)
            opened = await run(opening, heavy=is_large(size(files.body)))
            if isinstance(opened, Reply):
                raise JobRefusedError(opened.content)
            if opened is None:
                raise FileNotFoundError(_GONE)
            batch = _PatientBatch(
                job.request["request_id"],
                unpacked or files.body,
                job.request["media_type"],
                opened,
                settings,
                resources.enter_context(spool.files()),
                run,
                n_workers,
                self._metrics,
                {},
                told,
            )
            async with aclosing(batch.told_lines()) as lines:
                try:
                    async for line in lines:
                        yield line
                except ClientDisconnect:  # no client can have gone: a worker has missed a file
                    raise FileNotFoundError(_GONE) from None

    async def _room(self, job: Job, files: JobFiles) -> tuple[int, Spool]:
        """How many work on a job, and where its temporary files are: a cluster reaches its folder."""
        if isinstance(self._pool, Cluster):
            spool = Spool(files.folder, 0, job.attempt)
            await asyncio.to_thread(spool.clear)
            return await self._pool.size(), spool
        return self._settings().workers, self._spool


class _PatientBatch(Batch):
    """A full disk is no problem of an item: the job waits until there is room."""

    def _problem(self, error: Exception) -> Reply:
        if isinstance(error, InsufficientStorageError):
            raise error
        return super()._problem(error)


def open_job(asked: Any, body: bytes | Path, unpacked: Path | None, settings: Settings) -> OpenJob:
    """What a worker does first with a body; `asked` is the `request` of a job."""
    return OpenJob(
        asked["request_id"],
        body,
        asked["media_type"],
        asked["content_type"],
        asked["coding"],
        unpacked,
        [(name, value) for name, value in asked["query"]],
        settings.limits,
        settings.max_batch_items,
    )


def new_job(
    owner: str, key: str | None, asked: dict[str, Any], body: bytes | Path, held: bytes | Path, opened: Opened
) -> NewJob:
    """A job of a body that was opened; `held` is what it held, where it was packed."""
    fingerprint = _fingerprint(asked["media_type"], held, opened)
    return NewJob(str(uuid.uuid4()), owner, key, fingerprint, asked, len(opened.files), size(body))


def _fingerprint(media_type: str, held: bytes | Path, opened: Opened) -> str:
    """The same for the same files, options and labels: however they were packed and the parts divided."""
    digest = sha256()
    options = [media_type, opened.labels, opened.options.query, opened.options.beside]
    digest.update(orjson.dumps(options, option=orjson.OPT_SORT_KEYS))
    for part in opened.files:
        digest.update(orjson.dumps([part.filename, part.stop - part.start]))
        for piece in _pieces(held, part.start, part.stop):
            digest.update(piece)
    return digest.hexdigest()


def _pieces(held: bytes | Path, start: int, stop: int) -> Iterator[bytes]:
    for at in range(start, stop, _PIECE):
        end = min(at + _PIECE, stop)
        yield held[at:end] if isinstance(held, bytes) else Stretch(held, at, end).read()


def _steady(run: Run) -> Callable[..., Awaitable[Any]]:
    """`run` of the pool, again where a worker ended over a job, killed from outside or for its memory.

    When this has happened some times it is the answer.
    """

    async def again(job: Any, heavy: bool = False) -> Any:
        for n_tries in range(1, _TRIES + 1):
            try:
                result = await run(job, _never, heavy=heavy)
            except WorkerDiedError:
                if n_tries == _TRIES:
                    raise
                continue
            if isinstance(result, Reply) and result.facts.get("problem") == _NO_SPACE:
                raise InsufficientStorageError("a worker found no room for temporary files")
            return result

    return again


async def _never() -> bool:
    return False
