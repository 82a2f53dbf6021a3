"""What a process of a cluster does with a job, without a cluster; tests/ray has one."""

from dataclasses import replace
from pathlib import Path

import pytest

from primfit.app.readers.limits import Limits
from primfit.app.wire.problems import TimeLimitError
from primfit.app.workers import jobs
from primfit.app.workers.batch_jobs import FileJob, Found, Options
from primfit.app.workers.cluster import ClusterLostError, Terms, do
from tests.paths import EXAMPLES

TERMS = Terms("text", 2**30, 60.0)


@pytest.fixture
def job(tmp_path: Path) -> FileJob:
    scratch = tmp_path / "points"
    scratch.touch()
    content = (EXAMPLES / "cylinder.csv").read_bytes()
    return FileJob("r", content, "text/csv", False, None, Options([], {}), Limits(), scratch, 10)


def test_a_job_has_the_result_that_a_worker_of_the_service_has(job: FileJob) -> None:
    here, there = jobs.run(job), do(TERMS, job)
    assert isinstance(there, Found) and there.content == here.content
    job.scratch.unlink()
    assert do(TERMS, job) is None


def test_the_time_limit_holds(job: FileJob) -> None:
    with pytest.raises(TimeLimitError, match=r"not done within 0\.0001 s"):
        do(replace(TERMS, time_limit=1e-4), job)


def test_another_version_does_no_job(job: FileJob) -> None:
    with pytest.raises(
        ClusterLostError, match=r"a machine of the cluster has primfit .*, the service 0\.0\.1"
    ):
        do(replace(TERMS, version="0.0.1"), job)
