"""The records and the folder of the jobs, as an event loop asks for them."""

import asyncio
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from ..wire.problems import InsufficientStorageError, JobsUnavailableError, NoSuchJobError
from .files import Folder
from .record import Job, NewJob
from .store import Store
from .watch import Beat

P = ParamSpec("P")
T = TypeVar("T")
_ON_ITS_WAY = 600.0
"""Seconds that it takes, at most, from the first byte on the disk to the record."""
_THREADS = 4
"""Of its own: a database that does not answer holds up nobody who has no job."""


class Desk:
    """Takes jobs in and hands them out; all that waits for a disk or a database waits in a thread."""

    def __init__(self, store: Store, folder: Folder, most_jobs: int, most_bytes: int) -> None:
        """An owner may have `most_jobs` jobs and `most_bytes` bytes in them."""
        self.store, self.folder = store, folder
        self._most = most_jobs, most_bytes
        self._threads = ThreadPoolExecutor(_THREADS, "primfit-jobs")

    def close(self) -> None:
        self._threads.shutdown(wait=False, cancel_futures=True)
        self.store.close()

    async def call(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Have something done in a thread of the jobs."""
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._threads, lambda: function(*args, **kwargs))

    async def submit(self, new: NewJob, body: bytes | Path) -> Job:
        """Keep a job; when this returns, the disk holds its body and its record."""
        return await self.call(self._submit, new, body)

    def _submit(self, new: NewJob, body: bytes | Path) -> Job:
        # Whether the database answers, and would take it, is asked before anything is written.
        earlier = self.store.earlier(new, *self._most)
        if earlier is not None:
            return earlier
        self.folder.create(new.id, body)
        try:
            kept = self.store.add(new, *self._most)
        except JobsUnavailableError:
            raise  # nobody knows whether it has the record: the body stays
        except BaseException:
            self.folder.remove(new.id)
            raise
        if kept.id != new.id:  # the same came twice at the same time
            self.folder.remove(new.id)
        return kept

    async def find(self, job_id: str, owner: str) -> Job:
        """The job of this id.

        Raises
        ------
        NoSuchJobError
            There is none of this owner.
        """
        found = await self.call(self.store.find, job_id, owner)
        if found is None:
            raise NoSuchJobError("no job of yours has this id; jobs are removed some time after their end")
        return found

    async def listed(self, owner: str) -> list[Job]:
        return await self.call(self.store.listed, owner)

    async def place(self, job: Job) -> int:
        return await self.call(self.store.place, job)

    def take_over(self, silent: Beat, problem: Mapping[str, Any]) -> Job | None:
        """As `Store.take_over`; the body of a job that fails for it is removed."""
        job = self.store.take_over(silent, problem)
        if job is None and (left := self.store.find(silent.job_id)) is not None and left.ended:
            self.folder.of(left.id).remove_body()
        return job

    def dismiss(self, job: Job) -> None:
        """Cancel it; one that has ended is removed."""
        try:
            canceled = self.store.dismiss(job.id)
        except InsufficientStorageError:
            self.folder.of(job.id).remove_body()  # which makes room for the record
            canceled = self.store.dismiss(job.id)
        if canceled:
            self.folder.of(job.id).remove_body()
        else:
            self.remove(job.id)

    def remove(self, job_id: str) -> None:
        """A job that has ended: first its files, since on a full disk no record can be changed."""
        self.folder.remove(job_id)
        self.store.remove(job_id)

    def clean(self) -> int:
        """Remove the jobs that were kept for long enough, and say how many."""
        expired = self.store.expired()
        for job_id in expired:
            self.remove(job_id)
        return len(expired)

    def clear_strays(self) -> int:
        """Remove files that no record names, and say of how many jobs: a service died while it took them in.

        Only where somebody asks for it; a database that is not that of the folder refuses.
        """
        # In this order: a job that comes meanwhile has its files first.
        there = self.folder.ids()
        strays = [job_id for job_id in there - self.store.ids() if self._is_old(job_id)]
        for job_id in strays:
            self.folder.remove(job_id)
        return len(strays)

    def _is_old(self, job_id: str) -> bool:
        """Whether it can no longer be on its way in."""
        with suppress(FileNotFoundError):
            return time.time() - self.folder.of(job_id).folder.stat().st_mtime > _ON_ITS_WAY
        return False
