"""What is sent of a job that is removed meanwhile, or whose database goes: it ends, or goes on."""

import asyncio
from pathlib import Path
from typing import Any

import pytest
from starlette.requests import ClientDisconnect

from primfit.app.engine.items import Told
from primfit.app.jobs.clock import SteadyClock
from primfit.app.jobs.desk import Desk
from primfit.app.jobs.files import Folder
from primfit.app.jobs.record import SUCCESSFUL, Job, Progress
from primfit.app.jobs.store import Store, sqlite_url
from primfit.app.service import job_stream
from primfit.app.service.job_stream import Events, pieces
from primfit.app.wire.problems import JobsUnavailableError
from tests.app.jobs.making import MANY, new


@pytest.fixture
def desk(tmp_path: Path) -> Any:
    folder = Folder(tmp_path)
    desk = Desk(Store(sqlite_url(tmp_path), SteadyClock(), 60.0), folder, 9, MANY)
    yield desk
    desk.close()


def _ended(desk: Desk) -> Job:
    made = new()
    desk.folder.create(made.id, b"body")
    desk.store.add(made, 9, MANY)
    job = desk.store.claim()
    assert job is not None
    part = desk.folder.of(job.id).appender(1).append([(Told(1, 0, 1, "fitted", None), b"{}\n")])
    desk.store.end(job, Progress((part,), 1, 100), SUCCESSFUL)
    found = desk.store.find(job.id)
    assert found is not None
    return found


def test_a_page_of_a_job_that_is_removed_ends_its_connection(desk: Desk) -> None:
    job = _ended(desk)
    stretches = desk.folder.of(job.id).page(job.progress.parts, 0, 9)

    async def read() -> bytes:
        return b"".join([piece async for piece in pieces(desk, stretches)])

    assert asyncio.run(read()) == b"{}\n"
    desk.remove(job.id)
    with pytest.raises(ClientDisconnect):
        asyncio.run(read())


def test_events_of_a_job_that_is_removed_end(desk: Desk) -> None:
    job = _ended(desk)

    async def shown(_: Job) -> dict[str, Any]:
        return {}

    async def read() -> bytes:
        return b"".join([event async for event in Events(desk, job, shown, lambda: False).stream(0)])

    assert asyncio.run(read()).count(b"event: result") == 1
    desk.folder.remove(job.id)  # by hand, say: nothing will come any more
    assert asyncio.run(read()).endswith(b"event: status\nid: end\ndata: {}\n\n")
    desk.remove(job.id)
    assert b"event" not in asyncio.run(read())


def test_events_go_on_when_the_database_answers_again(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(job_stream, "_LOOK", 0.01)
    job, asked = _ended(desk), iter([JobsUnavailableError("down"), JobsUnavailableError("down"), {}])

    async def shown(_: Job) -> dict[str, Any]:
        document = next(asked)
        if isinstance(document, Exception):
            raise document
        return document

    async def read() -> bytes:
        return b"".join([event async for event in Events(desk, job, shown, lambda: False).stream(0)])

    told = asyncio.run(read())
    assert told.count(b"event: result") == 1 and told.endswith(b"id: end\ndata: {}\n\n")
