"""The container image, started for real: as whom it runs, who reaches it, what it holds, how it stops.

`PRIMFIT_IMAGE` names the image that `make image` built, `PRIMFIT_ENGINE` docker, podman or buildah. It runs
on a file system that is read-only but for /tmp, and without capabilities; with buildah, which runs nothing
that way, the test enters the file system of the image itself and must be root. Then it has a network of its
own, too, a pair of linked interfaces, for the names that others know it by.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator

from deploy.sbom import container, inventory, sbom
from tests.paths import EXAMPLES, ROOT

ENGINE = os.environ.get("PRIMFIT_ENGINE", "docker")
IMAGE = os.environ.get("PRIMFIT_IMAGE")
EXAMPLE = EXAMPLES / "cylinder.csv"
PORT = 18473
PATIENCE = 60
NETWORK = "primfit-test"
HERE, THERE = "10.231.7.1", "10.231.7.2"
"""The two ends of the network between this machine and a container."""
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


def test_it_answers_by_whatever_name_it_is_known(service: subprocess.Popen[bytes]) -> None:
    for host in ("localhost:8000", f"127.0.0.1:{PORT}", "primfit:8000", "primfit.example.com"):
        for path, body in (("/readyz", None), ("/fit", EXAMPLE.read_bytes())):
            headers = {"Host": host, "Content-Type": "text/csv"}
            request = urllib.request.Request(f"http://127.0.0.1:{PORT}{path}", body, headers)
            with urllib.request.urlopen(request, timeout=PATIENCE) as reply:
                assert reply.status == 200, host


@pytest.fixture
def network() -> Iterator[str]:
    """A network namespace that this machine reaches."""
    if ENGINE != "buildah" or shutil.which("ip") is None:
        pytest.skip("the network of another engine is not ours to make; needs buildah, root and iproute2")
    link = ["primfit-here", "type", "veth", "peer", "name", "primfit-there", "netns", NETWORK]
    _output("ip", "netns", "add", NETWORK)
    try:
        _output("ip", "link", "add", *link)
        for where, address, name in (((), HERE, link[0]), (("-n", NETWORK), THERE, link[5])):
            _output("ip", *where, "address", "add", f"{address}/30", "dev", name)
            _output("ip", *where, "link", "set", name, "up")
        yield NETWORK
    finally:
        _output("ip", "netns", "delete", NETWORK)


def test_it_is_reached_from_another_container_by_its_name(
    run: list[str], network: str, tmp_path: Path
) -> None:
    hosts = tmp_path / "hosts"
    hosts.write_text(f"127.0.0.1 localhost\n{THERE} primfit\n")
    known = ["unshare", "--mount", "sh", "-c", 'mount --bind "$0" /etc/hosts && exec "$@"', str(hosts)]
    ask = f"import urllib.request as u; print(u.urlopen('http://primfit:{PORT}/version', timeout=9).status)"
    process = subprocess.Popen(["ip", "netns", "exec", network, *run, "primfit", "serve"])
    try:
        _wait(f"http://{THERE}:{PORT}/readyz")
        assert _output(*known, sys.executable, "-c", ask) == "200\n"
    finally:
        process.terminate()
        process.wait(timeout=PATIENCE)


def test_the_list_of_its_parts_is_valid_and_has_the_versions_of_the_lock() -> None:
    with container(ENGINE, str(IMAGE)) as ask:
        written = sbom(str(IMAGE), inventory(ask))
    errors = JsonStrictValidator(SchemaVersion.V1_6).validate_str(written)
    assert errors is None, errors
    parts = {part["purl"] for part in json.loads(written)["components"]}
    for name in ("fastapi", "uvicorn", "pydantic", "orjson"):
        (pinned,) = re.findall(
            rf"^{name}==(\S+)", (ROOT / "requirements/image.txt").read_text(), re.MULTILINE
        )
        assert f"pkg:pypi/{name}@{pinned}" in parts
    assert any("/libc6@" in part for part in parts)
    assert not any(part.startswith(("pkg:pypi/torch@", "pkg:pypi/pip@")) for part in parts)


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


@pytest.mark.parametrize("host", ["primfit", "primfit:8000", "localhost:80", "10.42.0.7:8000"])
def test_it_is_asked_by_any_name(service: subprocess.Popen[bytes], host: str) -> None:
    """That of a container or of a published port, an address; but not by a page of elsewhere."""
    url = f"http://127.0.0.1:{PORT}/version"
    for path in ("/version", "/readyz"):
        request = urllib.request.Request(f"http://127.0.0.1:{PORT}{path}", headers={"Host": host})
        with urllib.request.urlopen(request, timeout=PATIENCE) as reply:
            assert reply.status == 200
    own = urllib.request.Request(url, headers={"Host": host, "Origin": f"http://{host}"})
    urllib.request.urlopen(own, timeout=PATIENCE).close()
    foreign = urllib.request.Request(url, headers={"Host": host, "Origin": "http://elsewhere"})
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(foreign, timeout=PATIENCE)


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
                with urllib.request.urlopen(f"http://127.0.0.1:{PORT}/{location}", timeout=PATIENCE) as reply:
                    assert json.load(reply)["files"] == 1
        finally:
            process.terminate()
            process.wait(timeout=PATIENCE)
