"""The service as a process: where it listens, how it starts and how it stops."""

import errno
import logging
import socket
import threading
from typing import Any

import uvicorn

from app import demo as first_look
from app.api import create_app
from app.settings import Settings

STOP_PATIENCE = 10
PROBES = ("/livez", "/readyz")


class ListenError(OSError):
    """The service cannot listen where it was told to; the message says why and what to do."""


def serve(host: str | None, port: int | None, workers: int | None, demo: bool) -> None:
    """Serve until a signal stops it; what is None comes from the environment (`Settings`)."""
    given: dict[str, Any] = {"host": host, "port": port, "workers": workers}
    settings = Settings(**{name: value for name, value in given.items() if value is not None})
    with listen(settings.host, settings.port) as listener:
        config = uvicorn.Config(create_app(settings), timeout_graceful_shutdown=STOP_PATIENCE)
        logging.getLogger("uvicorn.access").addFilter(_is_no_probe)
        logging.getLogger("uvicorn.error").info("Listening on %s port %d", *listener.getsockname()[:2])
        if demo:
            threading.Thread(target=first_look.show, args=(_url(listener),), daemon=True).start()
        try:
            uvicorn.Server(config).run(sockets=[listener])
        except KeyboardInterrupt:
            pass


def listen(host: str, port: int) -> socket.socket:
    """A listening socket, taken before anything slow is started.

    Raises
    ------
    ListenError
        If the port is in use or not allowed, or the host is not an address of this machine.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        listener = socket.create_server((host, port), family=family, backlog=2048)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            raise ListenError(
                f"port {port} on {host} is in use; choose another (--port, or PORT= with make run)"
            ) from error
        raise ListenError(f"cannot listen on {host} port {port}: {error.strerror or error}") from error
    # Its connections inherit this. Without, a body waits 40 ms until its header is acknowledged.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return listener


def _is_no_probe(record: logging.LogRecord) -> bool:
    """Leave the probes of orchestrators out of the access log: they come every few seconds."""
    return not any(f" {probe} " in record.getMessage() for probe in PROBES)


def _url(listener: socket.socket) -> str:
    """Where this machine reaches the service: an address that stands for all is reached on loopback."""
    host, port = listener.getsockname()[:2]
    local = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
    return f"http://[{local}]:{port}" if ":" in local else f"http://{local}:{port}"
