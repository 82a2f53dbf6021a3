"""How jobs are done by the workers of a service, with a pool that only notes what it is asked."""

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from primfit.app.jobs.files import Folder
from primfit.app.jobs.record import Job, Progress
from primfit.app.jobs.runner import JobRefusedError
from primfit.app.service.job_work import JobWork
from primfit.app.service.metrics import Metrics
from primfit.app.service.settings import Settings
from primfit.app.service.spool import Spool
from primfit.app.workers.batch_jobs import OpenJob
from primfit.app.workers.jobs import Reply

ASKED = {"request_id": "r", "media_type": "text/csv", "content_type": "text/csv", "coding": None, "query": []}
JOB = Job(1, "j", "", "f", ASKED, 1, "running", 1, 0, Progress(), 4, 0.0, 0.0, None, None, None, None, None)


class Noting:
    """A pool whose workers refuse every job, or miss a file of it."""

    def __init__(self, result: Reply | None) -> None:
        self.result = result
        self.asked: list[OpenJob] = []

    @contextmanager
    def batch(self) -> Iterator[Any]:
        async def run(job: OpenJob, *_: object, **__: object) -> Reply | None:
            self.asked.append(job)
            return self.result

        yield run


def _do(work: JobWork, tmp_path: Path) -> None:
    folder = Folder(tmp_path)
    if folder.ids() == set():
        folder.create("j", b"body")

    async def all_lines() -> None:
        async for _ in work(JOB, folder.of("j"), ()):
            pass

    asyncio.run(all_lines())


def test_a_job_is_done_by_the_limits_that_hold_when_it_is_begun(tmp_path: Path) -> None:
    in_force = [Settings(max_points=100)]
    pool: Any = Noting(Reply(422, b"{}"))
    work = JobWork(pool, Spool(tmp_path, None, 1), lambda: in_force[-1], Metrics())
    for _ in range(2):
        with pytest.raises(JobRefusedError):
            _do(work, tmp_path)
        in_force.append(Settings(max_points=200))
    assert [job.limits.points for job in pool.asked] == [100, 200]


def test_files_that_a_worker_misses_are_no_client_that_has_gone(tmp_path: Path) -> None:
    pool: Any = Noting(None)
    work = JobWork(pool, Spool(tmp_path, None, 1), Settings, Metrics())
    with pytest.raises(FileNotFoundError):
        _do(work, tmp_path)
