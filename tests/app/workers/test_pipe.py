"""The pipe to a worker: whole messages, in whatever pieces they come, and what is known where it ends."""

import asyncio
import pickle
import socket
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from primfit.app.workers.pipe import TAKEN, Pipe, packed, read

MESSAGES: list[Any] = [None, b"", "x" * 3, {"status": 200, "content": bytes(3_000_000)}]
Use = Callable[[Pipe, asyncio.StreamWriter], Awaitable[None]]


def _between(use: Use) -> None:
    """Run `use` with our end and a writer at the other."""

    async def run() -> None:
        ours, theirs = socket.socketpair()
        _, writer = await asyncio.open_connection(sock=theirs)
        transport, pipe = await asyncio.get_running_loop().create_connection(Pipe, sock=ours)
        try:
            await use(pipe, writer)
        finally:
            transport.abort()
            writer.transport.abort()

    asyncio.run(run())


@pytest.mark.parametrize("step", [1, 7, 9, 10**9])
def test_messages_arrive_whole_in_whatever_pieces_they_come(step: int) -> None:
    async def use(pipe: Pipe, writer: asyncio.StreamWriter) -> None:
        for message in MESSAGES if step > 9 else MESSAGES[:3]:
            content = TAKEN + packed(message)
            waiting = asyncio.create_task(pipe.message())
            for start in range(0, len(content), step):
                writer.write(content[start : start + step])
                await writer.drain()
                await asyncio.sleep(0)
            assert await waiting == message

    _between(use)


def test_a_message_that_was_there_before_it_is_waited_for_is_not_lost() -> None:
    async def use(pipe: Pipe, writer: asyncio.StreamWriter) -> None:
        writer.write(TAKEN + packed("first"))
        while not pipe.taken:
            await asyncio.sleep(0.01)
        assert await pipe.message() == "first" and not pipe.taken

    _between(use)


@pytest.mark.parametrize("sent", [b"", TAKEN, (TAKEN + packed("half of it"))[:-1]])
@pytest.mark.parametrize("waiting", [True, False])
def test_where_the_pipe_ends_it_is_known_whether_the_job_was_taken(sent: bytes, waiting: bool) -> None:
    async def use(pipe: Pipe, writer: asyncio.StreamWriter) -> None:
        task = asyncio.create_task(pipe.message()) if waiting else None
        writer.write(sent)
        await writer.drain()
        writer.close()
        while not pipe.closed:
            await asyncio.sleep(0.01)
        with pytest.raises(ConnectionError):
            await (task or pipe.message())
        assert pipe.taken == bool(sent)

    _between(use)


def test_a_worker_reads_what_was_sent_and_sees_the_end() -> None:
    async def run() -> None:
        ours, theirs = socket.socketpair()
        _, pipe = await asyncio.get_running_loop().create_connection(Pipe, sock=ours)
        with theirs:
            for message in MESSAGES:
                pipe.send(message)
                assert pickle.loads(await asyncio.to_thread(read, theirs)) == message
            pipe.abort()
            assert not await asyncio.to_thread(read, theirs)
        assert pipe.closed

    asyncio.run(run())
