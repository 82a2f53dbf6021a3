"""`primfit mcp` in a process of its own, and the official client that talks to it."""

import asyncio
import os
import subprocess
import sys
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import primfit
from tests.app.serving import LISTENING, PATIENCE, wait_for

pytest.importorskip("mcp", reason="needs the extra mcp: pip install 'primfit[mcp]'")
from httpx2 import AsyncClient
from mcp import Client, StdioServerParameters, stdio_client
from mcp.client.streamable_http import streamable_http_client

COMMAND = ["-m", "primfit", "mcp", "--workers", "1"]
SLOW = {"criterion": "maximum_inscribed", "kinds": ["cylinder"]}
"""Options with which the fit of `slow_cloud` takes seconds."""


@dataclass(frozen=True)
class Server:
    """A server over HTTP: its URL, its process, and the file of its log."""

    url: str
    pid: int
    log: Path

    @property
    def origin(self) -> str:
        return self.url.removesuffix("/mcp")


@contextmanager
def http_server(log: Path, *arguments: str, **settings: object) -> Iterator[Server]:
    """Start a server with these flags and settings on a free port, and stop it in the end."""
    with log.open("wb") as stderr:
        command = [sys.executable, *COMMAND, "--http", "--port", "0", *arguments]
        process = subprocess.Popen(command, env=environment(**settings), stderr=stderr)
    try:
        wait_for(lambda: LISTENING.search(log.read_text()) is not None)
        yield Server(f"http://127.0.0.1:{LISTENING.findall(log.read_text())[0]}/mcp", process.pid, log)
    finally:
        process.terminate()
        process.wait(PATIENCE)


@asynccontextmanager
async def stdio(folder: Path, *arguments: str, **settings: object) -> AsyncIterator[Client]:
    """A client of a server on standard input and output, which works in this folder."""
    server = StdioServerParameters(
        command=sys.executable, args=[*COMMAND, *arguments], env=environment(**settings), cwd=folder
    )
    async with Client(stdio_client(server)) as client:
        yield client


@asynccontextmanager
async def http_with(headers: dict[str, str], server: Server) -> AsyncIterator[Client]:
    """A client of a server over HTTP that sends these headers."""
    async with (
        AsyncClient(headers=headers) as http,
        Client(streamable_http_client(server.url, http_client=http)) as client,
    ):
        yield client


def environment(**settings: object) -> dict[str, str]:
    return {**os.environ, **{f"PRIMFIT_{name.upper()}": str(value) for name, value in settings.items()}}


def asked(server: Server, ask: Callable[[Client], Awaitable[Any]], mode: str = "auto") -> Any:
    """What a client of a server over HTTP gets."""

    async def run() -> Any:
        async with Client(server.url, mode=mode) as client:
            return await ask(client)

    return asyncio.run(run())


def words(result: Any) -> str:
    """The text of a result."""
    return str(result.content[0].text)


def write_cylinder(path: Path, n_points: int = 400, radius: float = 5.0) -> Path:
    """A file with a clean cylinder."""
    rng = np.random.default_rng(n_points)
    cylinder = primfit.Cylinder(axis=np.array([0.0, 0.0, 1.0]), point=np.zeros(3), radius=radius)
    points = cylinder.surface(rng.uniform(0, 6, n_points), rng.uniform(0, 20, n_points))
    np.save(path, points + rng.normal(0, 0.01, points.shape))
    return path


def write_slow_cloud(path: Path) -> Path:
    """A cylinder of nearly as many points as the service takes for a fit with `SLOW`: on fast machines that
    takes two seconds, and work that is given up ends after a quarter of one."""
    rng = np.random.default_rng(0)
    around, height = rng.uniform(0, 2 * np.pi, (2, 1_400_000))
    points = np.stack([np.cos(around), np.sin(around), height], axis=1)
    np.save(path, points + rng.normal(0, 0.01, points.shape))
    return path
