"""`primfit serve` as a process: an answer over HTTP, the same numbers by every way in, and a clean stop."""

import json
import os
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import primfit
from primfit.app.cli.commands import app
from primfit.app.service.server import ListenError, listen

COMMAND = [sys.executable, "-m", "primfit", "serve"]
PATIENCE = 60


@pytest.fixture(scope="module")
def cloud(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A noisy cone, so that digits would differ if anything did."""
    rng = np.random.default_rng(5)
    cone = primfit.Cone(np.array([1.0, -2.0, 0.5]), np.array([0.0, 0.6, 0.8]), 0.6)
    points = cone.surface(rng.uniform(0, 5, 700), rng.uniform(1, 4, 700)) + rng.normal(0, 0.002, (700, 3))
    path = tmp_path_factory.mktemp("cloud") / "cone.csv"
    np.savetxt(path, points, delimiter=",", header="x,y,z", comments="", fmt="%.17g")
    return path


@pytest.fixture(scope="module")
def service() -> Iterator[tuple[subprocess.Popen[str], list[str]]]:
    """A running `primfit serve --demo` on a free port, and the lines it printed until it was ready."""
    process = subprocess.Popen(
        [*COMMAND, "--port", "0", "--workers", "1", "--demo"], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    lines = []
    for line in process.stdout:
        lines.append(line.rstrip())
        if "Ctrl-C stops it" in line:
            break
    yield process, lines
    process.kill()
    process.wait()
    process.stdout.close()


def test_demo_prints_an_answer_and_the_curl_line_for_it(
    service: tuple[subprocess.Popen[str], list[str]],
) -> None:
    _, lines = service
    text = "\n".join(lines)
    body = json.loads(text[text.index("\n{") : text.rindex("\n}") + 2])
    assert body["status"] == "fitted"
    assert any(line.startswith("curl ") and line.endswith("/fit") for line in lines)


def test_rest_command_line_and_python_give_the_same_numbers(
    service: tuple[subprocess.Popen[str], list[str]], cloud: Path
) -> None:
    url = next(line for line in service[1] if line.startswith("curl ")).split()[-1]
    posted = urllib.request.urlopen(
        urllib.request.Request(url, cloud.read_bytes(), {"Content-Type": "text/csv"}), timeout=PATIENCE
    ).read()
    printed = CliRunner().invoke(app, ["fit", "--json", str(cloud)]).stdout_bytes
    assert printed == posted + b"\n"
    recognition = primfit.fit(np.loadtxt(cloud, delimiter=",", skiprows=1))
    assert recognition.primitive is not None
    assert primfit.parameters(recognition.primitive) == json.loads(posted)["primitive"]


@pytest.mark.skipif(os.name != "posix", reason="signals are those of POSIX")
def test_stops_cleanly_on_an_interrupt(service: tuple[subprocess.Popen[str], list[str]]) -> None:
    process, _ = service
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=PATIENCE) == 0


def test_a_port_in_use_is_said_plainly() -> None:
    with listen("127.0.0.1", 0) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(ListenError, match=f"port {port} on 127.0.0.1 is in use"):
            listen("127.0.0.1", port)
        result = CliRunner().invoke(app, ["serve", "--port", str(port)])
    assert result.exit_code == 2
    assert result.stderr.startswith("primfit: serve: port")
    assert len(result.stderr.splitlines()) == 1
