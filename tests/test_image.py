"""The container image, started for real: who it runs as, what it answers, what it does not hold.

`PRIMFIT_IMAGE` names the image that `make image` built, `PRIMFIT_ENGINE` docker, podman or buildah.
"""

import json
import os
import subprocess
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest

ENGINE = os.environ.get("PRIMFIT_ENGINE", "docker")
IMAGE = os.environ.get("PRIMFIT_IMAGE")
EXAMPLE = Path(__file__).parent.parent / "app" / "examples" / "cylinder.csv"
PORT = 18473
PATIENCE = 60

pytestmark = [
    pytest.mark.docker,
    pytest.mark.skipif(IMAGE is None, reason="PRIMFIT_IMAGE names no image (make image, docs/docker.md)"),
]


@pytest.fixture(scope="module")
def run() -> Iterator[list[str]]:
    """The command that runs something in a container of the image, as the image's own user."""
    if ENGINE != "buildah":
        yield [
            ENGINE,
            "run",
            "--rm",
            "--network",
            "host",
            "--env",
            f"PRIMFIT_PORT={PORT}",
            "--entrypoint",
            "",
        ]
        return
    container = _output("buildah", "from", str(IMAGE)).strip()
    yield ["buildah", "run", "--network", "host", "--env", f"PRIMFIT_PORT={PORT}", container, "--"]
    _output("buildah", "rm", container)


def _output(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def _in_container(run: list[str], *command: str) -> list[str]:
    return [*run, *command] if ENGINE == "buildah" else [*run, str(IMAGE), *command]


def test_it_runs_without_rights(run: list[str]) -> None:
    assert _output(*_in_container(run, "id", "-u")).strip() == "10001"


def test_it_holds_neither_torch_nor_pip(run: list[str]) -> None:
    script = "import importlib.util as u; print([n for n in ('torch', 'pip') if u.find_spec(n)])"
    assert _output(*_in_container(run, "python3", "-c", script)).strip() == "[]"


def test_fit_is_answered_and_a_signal_stops_it(run: list[str]) -> None:
    service = subprocess.Popen(_in_container(run, "primfit", "serve"))
    try:
        _wait(f"http://127.0.0.1:{PORT}/readyz")
        request = urllib.request.Request(
            f"http://127.0.0.1:{PORT}/fit", EXAMPLE.read_bytes(), {"Content-Type": "text/csv"}
        )
        with urllib.request.urlopen(request, timeout=PATIENCE) as reply:
            body = json.load(reply)
        assert body["status"] == "fitted"
        assert body["primitive"]["kind"] == "cylinder"
        assert body["receipt"]["versions"]["weights"] is not None
    finally:
        service.terminate()
        service.wait(timeout=PATIENCE)


def _wait(url: str) -> None:
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            urllib.request.urlopen(url, timeout=2).close()
            return
        except OSError:
            assert time.monotonic() < deadline, f"{url} was not ready after {PATIENCE} s"
            time.sleep(0.2)
