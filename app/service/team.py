"""The workers of a service, as its settings have them."""

from collections.abc import Iterable
from functools import partial

from ..workers import jobs
from ..workers.pool import WorkerPool
from .settings import Settings
from .spool import Spool


def worker_pool(settings: Settings, spool: Spool, preload: Iterable[str]) -> WorkerPool:
    """A pool that is not started yet; its workers remove the files of the spool if this process dies."""
    return WorkerPool(
        settings.workers,
        partial(jobs.warm, settings.log_format, settings.worker_memory),
        jobs.run,
        time_limit=settings.fit_time_limit,
        queue_size=settings.queue_size,
        preload=list(preload),
        litter=spool.pattern,
    )
