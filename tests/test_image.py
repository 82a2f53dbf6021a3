"""The container image, started for real: as whom it runs, what it answers, what it holds, how it stops.

`PRIMFIT_IMAGE` names the image that `make image` built, `PRIMFIT_ENGINE` docker, podman or buildah. It runs
on a file system that is read-only but for /tmp, and without capabilities; with buildah, which runs nothing
that way, the test enters the file system of the image itself and must be root.
"""

import json
import os
import subprocess
import threading
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.paths import EXAMPLES

ENGINE = os.environ.get("PRIMFIT_ENGINE", "docker")
IMAGE = os.environ.get("PRIMFIT_IMAGE")
EXAMPLE = EXAMPLES / "cylinder.csv"
PORT = 18473
PATIENCE = 60
ENTER = """set -eu
root=$1 user=$2 directory=$3
shift 3
mount --bind "$root" "$root"
mount -o remount,bind,ro "$root"
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mount -t tmpfs -o mode=1777 tmpfs "$root/tmp"
test -z "${JOBS:-}" || mount --bind "$JOBS" "$root/var/lib/primfit"
exec env -i "$(command -v chroot)" "$root" setpriv --reuid "${user%:*}" --regid "${user#*:}" --clear-groups \\
    --no-new-privs --inh-caps=-all --bounding-set=-all env --chdir "$directory" "$@"
"""

pytestmark = [
    pytest.mark.docker,
    pytest.mark.skipif(IMAGE is None, reason="PRIMFIT_IMAGE names no image (make image, docs/docker.md)"),
]


@pytest.fixture(scope="module")
def run() -> Iterator[list[str]]:
    """The command that runs something in a container of the image, as the image's own user."""
    port = f"PRIMFIT_PORT={PORT}"
    if ENGINE != "buildah":
        rights = [
            "--read-only",
            "--tmpfs",
            "/tmp",
            "--cap-drop",
            "ALL",
            "--security-opt",
            "no-new-privileges",
        ]
        yield [
            ENGINE,
            "run",
            "--rm",
            "--network",
            "host",
            "--env",
            port,
            "--entrypoint",
            "",
            *rights,
            str(IMAGE),
        ]
        return
    container = _output("buildah", "from", str(IMAGE)).strip()
    try:
        config = json.loads(_output("buildah", "inspect", container))["OCIv1"]["config"]
        root = _output("buildah", "mount", container).strip()
        place = [root, config["User"], config["WorkingDir"]]
        yield ["unshare", "--mount", "sh", "-c", ENTER, "sh", *place, *config["Env"], port]
    finally:
        _output("buildah", "rm", container)


@pytest.fixture
def service(run: list[str]) -> Iterator[subprocess.Popen[bytes]]:
    """The service in a container, ready."""
    process = subprocess.Popen([*run, "primfit", "serve"])
    try:
        _wait(f"http://127.0.0.1:{PORT}/readyz")
        yield process
    finally:
        process.terminate()
        process.wait(timeout=PATIENCE)


def _output(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def _python(run: list[str], script: str) -> str:
    return _output(*run, "python3", "-c", script).strip()


def _post(body: bytes, media_type: str) -> dict[str, object]:
    request = urllib.request.Request(f"http://127.0.0.1:{PORT}/fit", body, {"Content-Type": media_type})
    with urllib.request.urlopen(request, timeout=PATIENCE) as reply:
        answer: dict[str, object] = json.load(reply)
    return answer


def test_it_runs_without_rights(run: list[str]) -> None:
    assert _output(*run, "id", "-u").strip() == "10001"
    status = _output(*run, "cat", "/proc/self/status")
    assert "CapEff:\t0000000000000000" in status and "CapBnd:\t0000000000000000" in status


def test_it_holds_neither_torch_nor_pip_nor_the_tests_of_packages(run: list[str]) -> None:
    names = ("torch", "pip", "scipy.stats.tests")
    script = f"import importlib.util as u; print([name for name in {names} if u.find_spec(name)])"
    assert _python(run, script) == "[]"


def test_nothing_can_be_written_but_to_tmp(run: list[str]) -> None:
    script = """
import pathlib
for folder in ('/', '/opt/primfit', '/var', '/tmp'):
    try:
        pathlib.Path(folder, 'x').write_text('x')
        print(folder)
    except OSError:
        pass
"""
    assert _python(run, script) == "/tmp"


def test_fit_is_answered(service: subprocess.Popen[bytes]) -> None:
    body = _post(EXAMPLE.read_bytes(), "text/csv")
    assert body["status"] == "fitted"
    assert body["primitive"]["kind"] == "cylinder"  # type: ignore[index]
    assert body["receipt"]["versions"]["weights"] is not None  # type: ignore[index]


def test_a_signal_lets_a_request_finish_and_the_status_is_0(service: subprocess.Popen[bytes]) -> None:
    points = np.random.default_rng(0).normal(0.0, 1.0, (200_000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    body = "".join(f"{x},{y},{z}\n" for x, y, z in points.tolist()).encode()
    answers: list[dict[str, object]] = []
    asking = threading.Thread(target=lambda: answers.append(_post(body, "text/csv")))
    asking.start()
    time.sleep(0.2)
    service.terminate()
    asking.join(PATIENCE)
    assert answers and answers[0]["status"] == "fitted"
    assert service.wait(timeout=PATIENCE) == 0


def _wait(url: str) -> None:
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            urllib.request.urlopen(url, timeout=2).close()
            return
        except OSError:
            assert time.monotonic() < deadline, f"{url} was not ready after {PATIENCE} s"
            time.sleep(0.2)


def test_jobs_outlive_their_container(run: list[str], tmp_path: Path) -> None:
    folder, keeps = "/var/lib/primfit", "PRIMFIT_JOBS_PATH=/var/lib/primfit"
    # As an engine makes a new volume: it belongs to whom the folder of the image belongs to.
    os.chown(tmp_path, 10001, 10001)
    if ENGINE == "buildah":
        command = [*run, keeps, "primfit", "serve"]
    else:
        volume = ["--volume", f"{tmp_path}:{folder}", "--env", keeps]
        command = [*run[:2], *volume, *run[2:], "primfit", "serve"]
    location = ""
    for _ in range(2):
        process = subprocess.Popen(command, env={**os.environ, "JOBS": str(tmp_path)})
        try:
            _wait(f"http://127.0.0.1:{PORT}/readyz")
            if not location:
                body, headers = EXAMPLE.read_bytes(), {"Content-Type": "text/csv"}
                request = urllib.request.Request(f"http://127.0.0.1:{PORT}/jobs", body, headers)
                with urllib.request.urlopen(request, timeout=PATIENCE) as reply:
                    assert reply.status == 202
                    location = reply.headers["Location"]
            else:
                with urllib.request.urlopen(f"http://127.0.0.1:{PORT}{location}", timeout=PATIENCE) as reply:
                    assert json.load(reply)["files"] == 1
        finally:
            process.terminate()
            process.wait(timeout=PATIENCE)
