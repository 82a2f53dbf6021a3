"""Work that is done side by side, with results in the order of the work."""

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable
from contextlib import aclosing
from typing import TypeVar

T = TypeVar("T")


async def in_order(
    jobs: AsyncGenerator[Callable[[], Awaitable[T]], None], ahead: int
) -> AsyncGenerator[T, None]:
    """The results of jobs, in their order.

    At most `ahead` jobs are begun whose results have not been used; no further one is asked for before. When
    the generator is closed, or a job fails, the others are cancelled.
    """
    begun: asyncio.Queue[asyncio.Task[T] | None] = asyncio.Queue()
    room = asyncio.Semaphore(ahead)
    tasks: set[asyncio.Task[T]] = set()

    async def begin() -> None:
        try:
            async with aclosing(jobs):
                await room.acquire()
                async for job in jobs:
                    task = asyncio.ensure_future(_done(job))
                    tasks.add(task)
                    begun.put_nowait(task)
                    await room.acquire()
        finally:
            begun.put_nowait(None)

    beginner = asyncio.create_task(begin())
    try:
        while task := await begun.get():
            yield await task
            tasks.discard(task)
            room.release()
        await beginner
    finally:
        for unfinished in (beginner, *tasks):
            unfinished.add_done_callback(_forget)
            unfinished.cancel()


async def _done(job: Callable[[], Awaitable[T]]) -> T:
    return await job()


def _forget(task: asyncio.Task[T]) -> None:
    """Look at what went wrong, so that nobody is told of it when the task is thrown away."""
    if not task.cancelled():
        task.exception()
