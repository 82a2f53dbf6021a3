"""The jobs of a service from its start to its end. What they need is imported only where they are kept."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from fastapi import FastAPI

from .settings import Settings

if TYPE_CHECKING:
    from ..jobs.desk import Desk
    from ..workers.cluster import Cluster


@asynccontextmanager
async def jobs_kept(app: FastAPI) -> AsyncIterator[None]:
    """`state.desk` takes jobs and this service works on them; it is None where `jobs_path` is not set."""
    settings: Settings = app.state.settings
    app.state.desk = None
    if settings.jobs_path is None:
        yield
        return
    desk = await asyncio.to_thread(open_desk, settings)
    from ..jobs.runner import Runner
    from .job_work import JobWork

    cluster = cluster_of(settings)
    work = JobWork(cluster or app.state.pool, app.state.spool, lambda: app.state.settings, app.state.metrics)
    runner = Runner(desk, work, settings.workers, lambda: app.state.stopping)
    app.state.desk = desk
    runner.start()
    try:
        yield
    finally:
        await runner.stop()
        if cluster is not None:
            cluster.stop()
        desk.close()


def cluster_of(settings: Settings) -> "Cluster | None":
    """Who works on jobs where it is not this service."""
    if settings.jobs_executor == "local":
        return None
    from ..workers.cluster import Cluster, Terms

    return Cluster(
        settings.jobs_address, Terms(settings.log_format, settings.worker_memory, settings.fit_time_limit)
    )


def check_database(settings: Settings) -> None:
    """Look whether `jobs_database` is that of `jobs_path`; one that does not answer is looked at later.

    Raises
    ------
    WrongDatabaseError
        It is not.
    """
    if settings.jobs_path is None:
        return
    from ..jobs.files import WrongDatabaseError
    from ..wire.problems import InsufficientStorageError, JobsUnavailableError

    desk = open_desk(settings)
    try:
        desk.store.open()
    except WrongDatabaseError:
        raise
    except (JobsUnavailableError, InsufficientStorageError):
        pass
    finally:
        desk.close()


def open_desk(settings: Settings) -> "Desk":
    """The jobs in `jobs_path`, which is made where it is missing, and in `jobs_database`."""
    from ..jobs.clock import SteadyClock
    from ..jobs.desk import Desk
    from ..jobs.files import Folder
    from ..jobs.store import Store, sqlite_url

    assert settings.jobs_path is not None
    folder = Folder(settings.jobs_path)
    database = settings.jobs_database
    url = sqlite_url(folder.path) if database is None else database.get_secret_value()
    store = Store(url, SteadyClock(), settings.jobs_keep, folder.belong)
    return Desk(store, folder, settings.jobs_per_client, settings.job_bytes_per_client)
