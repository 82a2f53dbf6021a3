"""The service as a process: where it listens, how it starts and how it stops."""

import asyncio
import errno
import ipaddress
import logging
import signal
import socket
import sys
import threading
from collections.abc import Collection, Mapping
from functools import partial
from typing import Any

import uvicorn
from starlette.types import ASGIApp

from ..wire.problems import JobsUnavailableError
from ..workers import logs
from . import demo as first_look
from .api import create_app
from .connection import Connection
from .door import Door
from .guard import Access
from .jobs_kept import check_database
from .listener import Listener
from .metrics import Metrics
from .settings import RENEWABLE, Settings, SettingsError, load

_log = logging.getLogger("primfit")


class ListenError(OSError):
    """The service cannot listen where it was told to; the message says why and what to do."""


def serve(host: str | None, port: int | None, workers: int | None, demo: bool) -> None:
    """Serve until a signal stops it; what is None comes from the environment or a file (`Settings`)."""
    given: dict[str, Any] = {"host": host, "port": port, "workers": workers}
    flags = {name: value for name, value in given.items() if value is not None}
    settings = load(**flags)
    try:
        check_database(settings)
    except JobsUnavailableError as error:
        raise SettingsError(str(error)) from None
    except OSError as error:
        raise SettingsError(f"jobs_path: {settings.jobs_path}: {error.strerror}") from None
    with listen(settings.host, settings.port) as listener:
        logs.configure(settings.log_format)
        address, taken_port = listener.getsockname()[:2]
        _log.info("Listening on %s port %d", address, taken_port)
        if not settings.keys() and not is_loopback(address):
            _log.warning(
                "Everybody who reaches this address may use the service: no API key is set (api_keys)"
            )
        if demo:
            threading.Thread(target=first_look.show, args=(_url(listener),), daemon=True).start()
        # The server catches both signals, and sends them again when it has stopped.
        signal.signal(signal.SIGTERM, lambda *_: sys.exit())
        server = _Server(settings, is_loopback(address))
        if hasattr(signal, "SIGHUP"):
            signal.signal(signal.SIGHUP, lambda *_: server.renew(flags))
        try:
            server.run(sockets=[listener])
        except KeyboardInterrupt:
            pass


def renewed(old: Settings, flags: Mapping[str, Any], access: Access, names: Collection[str]) -> Settings:
    """The settings after SIGHUP, of which those of these names are read again, and the keys with them.

    If they cannot be read, or no key would be left, nothing changes; the log says so.
    """
    try:
        read = load(**flags)
        keys = read.keys()
    except (SettingsError, OSError, ValueError) as error:
        _log.error("SIGHUP: nothing is changed: %s", error)
        return old
    if access.asks_for_keys and not keys:
        _log.error("SIGHUP: nothing is changed: no key would be left, and everybody could ask")
        return old
    changed = [name for name in Settings.model_fields if getattr(read, name) != getattr(old, name)]
    later = [name for name in changed if name not in names]
    access.renew(keys, read.rate_limit)
    _log.info("SIGHUP: settings and keys are read again")
    if later:
        _log.warning("SIGHUP: %s will change when the service is started anew", ", ".join(later))
    return old.model_copy(update={name: getattr(read, name) for name in names})


class WatchedServer(uvicorn.Server):
    """A server of an ASGI application that watches its connections."""

    def __init__(self, app: ASGIApp, settings: Settings, metrics: Metrics) -> None:
        self._door = Door(settings, metrics)
        config = uvicorn.Config(
            app,
            http=partial(Connection, self._door),  # type: ignore[arg-type]
            ws="none",
            headers=[("X-Content-Type-Options", "nosniff")],
            log_config=None,
            access_log=False,
            proxy_headers=bool(settings.trusted_proxies),
            forwarded_allow_ips=list(settings.trusted_proxies),
            timeout_graceful_shutdown=settings.stop_patience,
        )
        super().__init__(config)

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listen, and look after the connections from then on."""
        await super().startup(sockets)
        self._watch = asyncio.create_task(self._door.watch(self.server_state.connections))

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Close the listener and let requests under way finish."""
        await super().shutdown(sockets)
        self._watch.cancel()


class _Server(WatchedServer):
    """The service, which says that it is about to stop before it does."""

    def __init__(self, settings: Settings, local: bool) -> None:
        self._app, self._delay = create_app(settings, local), settings.stop_delay
        super().__init__(self._app, settings, self._app.state.metrics)

    def renew(self, flags: Mapping[str, Any]) -> None:
        """Read the settings again, and go by those from now on that can change while the service runs."""
        state = self._app.state
        state.settings = renewed(state.settings, flags, state.access, RENEWABLE)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Take requests for a moment longer, then close the listener and let those under way finish."""
        self._app.state.stopping = True
        await asyncio.sleep(self._delay)
        await super().shutdown(sockets)


def listen(host: str, port: int) -> socket.socket:
    """A listening socket, taken before anything slow is started.

    Raises
    ------
    ListenError
        If the port is in use or not allowed, or the host is not an address of this machine.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        taken = socket.create_server((host, port), family=family, backlog=2048)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            raise ListenError(
                f"port {port} on {host} is in use; choose another (--port, or PORT= with make run)"
            ) from error
        raise ListenError(f"cannot listen on {host} port {port}: {error.strerror or error}") from error
    listener = Listener(fileno=taken.detach())
    # Its connections inherit this. Without, a body waits 40 ms until its header is acknowledged.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return listener


def is_loopback(address: str) -> bool:
    """Whether only this machine reaches an IP address."""
    return ipaddress.ip_address(address.partition("%")[0]).is_loopback


def _url(listener: socket.socket) -> str:
    """Where this machine reaches the service: an address that stands for all is reached on loopback."""
    host, port = listener.getsockname()[:2]
    local = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
    return f"http://[{local}]:{port}" if ":" in local else f"http://{local}:{port}"
