"""A PostgreSQL server of Debian's package, started for tests on a free port in a folder of its own."""

import os
import pwd
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

FOUND = shutil.which("postgres")
needs_postgres = pytest.mark.skipif(FOUND is None, reason="needs postgres (apt install postgresql)")
_PATIENCE = 60.0


class Postgres:
    """One server; it may be killed, and started again on what its disk holds."""

    def __init__(self, folder: Path) -> None:
        assert FOUND is not None
        self._programs = Path(FOUND).resolve().parent
        self._data, self.folder = folder / "data", folder
        self._process: subprocess.Popen[bytes] | None = None
        # It refuses to run as root.
        self._user = pwd.getpwnam("nobody").pw_uid if os.geteuid() == 0 else None
        if self._user is not None:
            os.chown(folder, self._user, -1)
        initdb = [self._programs / "initdb", "--no-sync", "--auth=trust", "--username=primfit"]
        subprocess.run(
            [*initdb, "--pgdata", self._data], check=True, capture_output=True, user=self._user, cwd=folder
        )
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]

    def url(self, database: str = "postgres") -> str:
        return f"postgresql://primfit@127.0.0.1:{self.port}/{database}"

    def start(self) -> None:
        settings = {"listen_addresses": "127.0.0.1", "port": self.port, "shared_buffers": "16MB"}
        settings |= {"unix_socket_directories": self.folder, "max_connections": 50}
        command = [self._programs / "postgres", "-D", self._data]
        command += [part for name, value in settings.items() for part in ("-c", f"{name}={value}")]
        with (self.folder / "postgres.log").open("ab") as log:
            self._process = subprocess.Popen(
                command, stderr=log, user=self._user, cwd=self.folder, start_new_session=True
            )
        end = time.monotonic() + _PATIENCE
        while not self._answers():
            assert time.monotonic() < end, (self.folder / "postgres.log").read_text()
            time.sleep(0.1)

    def _answers(self) -> bool:
        ready = [self._programs / "pg_isready", "-q", "-h", "127.0.0.1", "-p", str(self.port)]
        return subprocess.run(ready, check=False).returncode == 0

    def kill(self) -> None:
        """SIGKILL for it and all its processes."""
        assert self._process is not None
        os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    def create(self, database: str) -> str:
        """The URL of a new, empty database."""
        import psycopg

        with psycopg.connect(self.url(), autocommit=True) as connection:
            connection.execute(f"CREATE DATABASE {database}")  # type: ignore[arg-type]
        return self.url(database)


@contextmanager
def started() -> Iterator[Postgres]:
    """A server that ends, with its folder, when this is left."""
    # Not a folder of pytest's: others than root cannot enter these.
    folder = Path(tempfile.mkdtemp(prefix="primfit-postgres-"))
    server = Postgres(folder)
    try:
        server.start()
        yield server
    finally:
        server.kill()
        shutil.rmtree(folder, ignore_errors=True)
