"""The MCP server: over standard input and output for a program on this machine, or over HTTP."""

import asyncio
import logging
import os
import signal
import sys
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from mcp.server.mcpserver import Context, MCPServer
from mcp_types import CallToolResult, InputRequiredResult

from ..readers.formats import FORMATS
from ..service.settings import Settings
from ..service.spool import Spool
from ..service.team import worker_pool
from ..workers import PRELOAD as OF_SERVICE
from ..workers import logs
from .output import unfinished
from .places import Places
from .tickets import Tickets
from .tools import Tools, called

PRELOAD = [*OF_SERVICE, "primfit.app.agents.work", "primfit.app.agents.picture"]
SWEEP_SECONDS = 5.0
"""Between two looks for tickets whose time is over."""


def instructions(settings: Settings, places: Places, uploads: bool) -> str:
    """What a model is told of the server: what it does, with which files, within which limits."""
    formats = ", ".join(dict.fromkeys(format.name for format in FORMATS))
    ways = [f"Name a file by its path ({places.roots.said}), never send its contents."]
    if uploads:
        ways.append(
            "Other files: call upload, PUT the file to the URL, and give the ticket in place of a path."
        )
    writes = (
        f"export writes into {places.output}."
        if places.output
        else "export is off: the server was started without --output."
    )
    return "\n".join(
        [
            "primfit says which geometric primitive (plane, sphere, cylinder, cone, torus) a piece of a 3D "
            "point cloud is, with its parameters, their 95% intervals, and why. explain shows the fit.",
            *ways,
            f"Formats: {formats}, also packed by gzip or zstd. A file of several surfaces needs labels: "
            "fit_segments.",
            f"Limits: {settings.max_body_bytes} bytes of a file, also unpacked; {settings.max_points} points "
            f"of a cloud; {settings.fit_time_limit:g} seconds for reading and fitting one cloud; "
            f"{settings.max_batch_items} segments of a scan.",
            "Units: lengths are in the unit of the file, which the answer names where it is known, or the "
            "option unit does; nothing is converted. Angles are in radians.",
            writes,
        ]
    )


class Server(MCPServer[Any]):
    """The server of the package, which would take arguments that no tool has for nothing."""

    async def call_tool(
        self, name: str, arguments: dict[str, Any], context: Context[Any, Any] | None = None
    ) -> CallToolResult | InputRequiredResult:
        """Call a tool; arguments that it does not have, or of a wrong type, are mistakes like others."""
        schemas = {tool.name: tool.input_schema for tool in await self.list_tools()}
        call = partial(super().call_tool, name, arguments, context)
        return await called(call, arguments, schemas[name]["properties"] if name in schemas else None)


@asynccontextmanager
async def running(
    settings: Settings, places: Places, uploads: bool
) -> AsyncIterator[tuple[MCPServer[Any], Tools]]:
    """The server with its tools, and the processes that work for them; both end with the block."""
    spool = Spool(settings.temporary_directory, settings.max_spooled_bytes, os.getpid())
    pool = worker_pool(settings, spool, PRELOAD)
    tickets = Tickets(spool, settings.max_body_bytes) if uploads else None
    tools = Tools(settings, pool, places.roots, spool, places.output, tickets)
    server = Server(
        "primfit",
        title="primfit",
        version=version("primfit"),
        instructions=instructions(settings, places, uploads),
        subscriptions=False,
        log_level="WARNING",
    )
    # The package has set up a log of its own.
    logs.configure(settings.log_format)
    logging.getLogger("mcp").setLevel(logging.WARNING)
    tools.add_to(server)
    pool.start()
    async with AsyncExitStack() as resources:
        resources.callback(_remove_unfinished, places.output)
        resources.callback(pool.stop)
        if tickets is not None:
            await resources.enter_async_context(tickets.kept())
            sweeper = asyncio.create_task(_sweep(tickets))
            resources.callback(sweeper.cancel)
        yield server, tools


async def _sweep(tickets: Tickets) -> None:
    while True:
        await asyncio.sleep(SWEEP_SECONDS)
        await tickets.sweep()


def _remove_unfinished(output: Path | None) -> None:
    """Files that a process was writing when it was ended."""
    for file in output.glob(f"{unfinished(os.getpid())}*") if output else ():
        file.unlink(missing_ok=True)


def serve_stdio(settings: Settings, places: Places) -> None:
    """Serve until the client closes standard input, or a signal ends this process."""
    asyncio.run(_serve_stdio(settings, places))


async def _serve_stdio(settings: Settings, places: Places) -> None:
    async with running(settings, places, uploads=False) as (server, _):
        served = asyncio.create_task(server.run_stdio_async())
        signaled = _signaled()
        await asyncio.wait((served, signaled), return_when=asyncio.FIRST_COMPLETED)
    if not served.done():
        # A thread waits for the next line still, and nothing but its end would wake it.
        print("primfit: mcp: interrupted", file=sys.stderr, flush=True)
        os._exit(128 + signaled.result())
    served.result()


def _signaled() -> "asyncio.Future[int]":
    """Done with the number of the first signal that asks this process to end."""
    loop = asyncio.get_running_loop()
    number: asyncio.Future[int] = loop.create_future()

    def note(which: int) -> None:
        if not number.done():
            number.set_result(which)

    with suppress(NotImplementedError):  # on Windows
        for which in (signal.SIGINT, signal.SIGTERM):
            loop.add_signal_handler(which, note, which)
    return number
