"""The life of a worker process: warm up, then one job after the other until the service ends."""

import os
import pickle
import select
import signal
import socket
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .pipe import TAKEN, packed, read

Work = Callable[[Any], Any]


class WornOutError(Exception):
    """A job that has a `result`, but after which the process should do no other."""

    def __init__(self, result: Any) -> None:
        super().__init__(result)
        self.result = result


def serve(pipe: socket.socket, warm: Callable[[], Any], work: Work, litter: Path | None) -> None:
    """Warm up, say so, then confirm and do jobs until the pipe closes.

    `litter` is the pattern of the service's temporary files, which go if it dies.
    """
    # A signal to the whole group is for the service, which lets us finish and then ends us.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(5)
    if hasattr(select, "poll"):
        threading.Thread(target=_end_with_service, args=(pipe, litter), daemon=True).start()
    try:
        greeting = (True, warm())
    except Exception as error:
        greeting = (False, f"{type(error).__name__}: {error}")
    try:
        pipe.sendall(TAKEN + packed(greeting))
        while content := read(pipe):
            job = pickle.loads(content)
            pipe.sendall(TAKEN)
            try:
                result = work(job)
            except WornOutError as last:
                pipe.sendall(packed(last.result))
                return
            pipe.sendall(packed(result))
    except ConnectionError:
        pass  # it died with something on its way
    _remove(litter)


def _end_with_service(pipe: socket.socket, litter: Path | None) -> None:
    """Wait until the other end of the pipe closes: the service has died, else it had killed us first."""
    ended = select.poll()
    ended.register(pipe, 0)
    ended.poll()
    _remove(litter)
    os.kill(os.getpid(), signal.SIGKILL)


def _remove(litter: Path | None) -> None:
    for file in litter.parent.glob(litter.name) if litter else ():
        file.unlink(missing_ok=True)
