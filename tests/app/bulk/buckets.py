"""An object store that runs here, by moto, and that fails now and then in the ways of real ones."""

import socket
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

_BUSY = (
    b"<?xml version='1.0'?><Error><Code>%s</Code><Message>Please reduce your request rate.</Message></Error>"
)
FAULTS = ("503", "slow down", "429", "dropped", "half")


class Faults:
    """A layer over a WSGI application that fails the first `times` requests of each method and path.

    `kinds` follow each other: an answer 503 or 429 without a reason or with one (`slow down`), a connection
    that is dropped before the answer, or after half of it. `counts` says how often each was met.
    """

    def __init__(self, application: Callable[..., Iterable[bytes]]) -> None:
        self._application = application
        self._lock, self._asked = threading.Lock(), Counter[str]()
        self.kinds: tuple[str, ...] = ()
        self.times = 0
        self.counts: Counter[str] = Counter()

    def begin(self, kinds: tuple[str, ...], times: int) -> None:
        """Fail from now on; all paths are new."""
        with self._lock:
            self.kinds, self.times = kinds, times
            self._asked.clear()
            self.counts.clear()

    def __call__(self, environ: dict[str, Any], start_response: Any) -> Iterable[bytes]:
        kind = self._next(f"{environ['REQUEST_METHOD']} {environ['PATH_INFO']} {environ.get('HTTP_RANGE')}")
        if kind is None:
            return self._application(environ, start_response)
        # What was sent has to be read, or the connection is at odds.
        environ["wsgi.input"].read(int(environ.get("CONTENT_LENGTH") or 0))
        if kind == "half" and environ["REQUEST_METHOD"] == "GET":
            return self._half(environ, start_response)
        if kind in ("dropped", "half"):
            _drop(environ)
        status = {"503": "503 Service Unavailable", "429": "429 Too Many Requests"}.get(kind, "503 Slow Down")
        start_response(status, [("Content-Type", "application/xml")])
        return [_BUSY % (b"SlowDown" if kind == "slow down" else b"ServiceUnavailable")]

    def _next(self, request: str) -> str | None:
        with self._lock:
            number = self._asked[request]
            self._asked[request] += 1
            if number >= self.times or not self.kinds:
                return None
            kind = self.kinds[self.counts.total() % len(self.kinds)]
            self.counts[kind] += 1
            return kind

    def _half(self, environ: dict[str, Any], start_response: Any) -> Iterator[bytes]:
        body = b"".join(self._application(environ, start_response))
        yield body[: len(body) // 2]
        _drop(environ)


def _drop(environ: dict[str, Any]) -> NoReturn:
    environ["werkzeug.socket"].shutdown(socket.SHUT_RDWR)
    raise ConnectionAbortedError


@contextmanager
def bucket_server() -> Iterator[tuple[str, Faults]]:
    """The address of a server of S3, and what makes it fail."""
    from moto.server import DomainDispatcherApplication, create_backend_app
    from werkzeug.serving import WSGIRequestHandler, make_server

    class Quiet(WSGIRequestHandler):
        def log(self, *_: Any) -> None:
            """Says nothing."""

    faults = Faults(DomainDispatcherApplication(create_backend_app))
    server = make_server("127.0.0.1", 0, faults, threaded=True, request_handler=Quiet)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}", faults
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
