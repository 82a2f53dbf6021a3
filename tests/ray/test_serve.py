"""The service as an application of Ray Serve: answers, more replicas under load, one of them killed."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import httpx
import pytest

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
ray = pytest.importorskip("ray", reason="needs the extra ray: make test-ray")
serve = pytest.importorskip("ray.serve", reason="needs the extra ray: make test-ray")

from ray.serve.schema import ServeDeploySchema

from primfit.app.service import ray_serve
from primfit.app.service.settings import SettingsError
from primfit.benchmark.scaling.cluster import cluster as nodes_here
from primfit.benchmark.scaling.cluster import workers_of
from tests.paths import ROOT

# Ray leaves files and processes to the end of its own.
pytestmark = [pytest.mark.ray, pytest.mark.filterwarnings("default")]

SAMPLES = ("pipe.ply", "tank-end.xyz", "nozzle.pcd")
CLIENTS = 4
PATIENCE = 60.0


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with nodes_here(0, head_cpus=2) as made:
        ray.init(address=made.address, log_to_driver=False, logging_level="error")
        yield made
        serve.shutdown()
        ray.shutdown()


@pytest.fixture(scope="module")
def url(cluster: Any) -> str:
    """Where the application listens, with one replica that may become two."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    serve.start(http_options={"port": port})
    arguments = ray_serve.Arguments(
        max_replicas=2, target_ongoing_requests=1, upscale_delay_s=0.5, downscale_delay_s=600
    )
    serve.run(ray_serve.app(arguments))
    return f"http://127.0.0.1:{port}"


@pytest.fixture(scope="module")
def answers() -> dict[str, bytes]:
    """What the command line says of the samples."""
    files = [str(ROOT / "samples" / name) for name in SAMPLES]
    command = [sys.executable, "-m", "primfit", "fit", "--json"]
    return {
        Path(file).name: subprocess.run([*command, file], check=True, stdout=subprocess.PIPE).stdout
        for file in files
    }


def post(url: str, name: str) -> httpx.Response:
    content = (ROOT / "samples" / name).read_bytes()
    headers = {"Content-Type": "application/octet-stream"}
    return httpx.post(f"{url}/fit", content=content, headers=headers, timeout=PATIENCE)


def test_answers_are_those_of_the_command_line(url: str, answers: dict[str, bytes]) -> None:
    for name, answer in answers.items():
        response = post(url, name)
        assert response.status_code == 200
        assert json.loads(response.content) == json.loads(answer)
        assert len(response.headers.get_list("x-request-id")) == 1
    assert httpx.get(f"{url}/readyz").json() == {"status": "ready", "workers": 1}
    refused = httpx.post(f"{url}/fit", content=b"", headers={"Content-Type": "text/csv"})
    assert refused.status_code == 422 and refused.headers["content-type"] == "application/problem+json"


def test_load_brings_a_second_replica_and_one_that_is_killed_loses_no_answer(
    cluster: Any, url: str, answers: dict[str, bytes]
) -> None:
    assert replicas() == 1
    load = [Load(url, answers) for _ in range(CLIENTS)]
    for client in load:
        client.start()
    try:
        wait_for(lambda: replicas() == 2)
        killed, other = processes(cluster)
        os.kill(killed, signal.SIGKILL)
        wait_for(lambda: replicas() == len({*processes(cluster), other} - {killed}) == 2)
        before = [client.answered for client in load]
        wait_for(lambda: all(client.answered > n for client, n in zip(load, before, strict=True)))
    finally:
        for client in load:
            client.go_on = False
        for client in load:
            client.join()
    assert [client.wrong for client in load] == [[]] * CLIENTS


class Load(threading.Thread):
    """A client that asks again and again, and again for the same where it got no answer."""

    def __init__(self, url: str, answers: dict[str, bytes]) -> None:
        super().__init__()
        self._url, self._answers = url, answers
        self.go_on, self.answered = True, 0
        self.wrong: list[str] = []

    def run(self) -> None:
        while self.go_on:
            for name, answer in self._answers.items():
                if json.loads(self._answer(name)) != json.loads(answer):
                    self.wrong.append(name)
                self.answered += 1

    def _answer(self, name: str) -> bytes:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            with suppress(httpx.TransportError):
                response = post(self._url, name)
                if response.status_code < 500:
                    return response.content
            time.sleep(0.1)
        return b"null"


def replicas() -> int:
    """How many of them run."""
    return int(serve.status().applications["default"].deployments["primfit"].replica_states.get("RUNNING", 0))


def processes(cluster: Any) -> list[int]:
    """Of the replicas."""
    return [
        process
        for node in cluster.list_all_nodes()
        for process in workers_of(node)
        if b"ServeReplica" in command_line(process)
    ]


def command_line(process: int) -> bytes:
    with suppress(OSError):  # it has ended
        return Path(f"/proc/{process}/cmdline").read_bytes()
    return b""


def wait_for(condition: Any) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.1)


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("RATE_LIMIT", "5/second", "rate_limit: each replica would count for itself"),
        ("HEAD_TIMEOUT", "5", "head_timeout: it has no effect under Ray Serve"),
        ("JOBS_PATH", "{folder}", "jobs_path: replicas may be on several machines"),
    ],
)
def test_settings_that_replicas_cannot_keep_are_refused(
    name: str, value: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(f"PRIMFIT_{name}", value.format(folder=tmp_path))
    with pytest.raises(SettingsError, match=told):
        ray_serve.app(ray_serve.Arguments())


def test_a_replica_has_the_workers_that_are_asked_for_else_one(monkeypatch: pytest.MonkeyPatch) -> None:
    assert ray_serve.replica_settings().workers == 1
    monkeypatch.setenv("PRIMFIT_WORKERS", "3")
    assert ray_serve.replica_settings().workers == 3


def test_ray_serve_reads_its_part_of_the_example_for_kuberay() -> None:
    yaml = pytest.importorskip("yaml")
    objects = yaml.safe_load_all((ROOT / "deploy" / "kuberay.yaml").read_text())
    (service,) = [made for made in objects if made["kind"] == "RayService"]
    config = ServeDeploySchema.model_validate(yaml.safe_load(service["spec"]["serveConfigV2"]))
    (application,) = config.applications
    module, _, name = application.import_path.partition(":")
    assert (module, getattr(ray_serve, name)) == (ray_serve.__name__, ray_serve.app)
    ray_serve.app(ray_serve.Arguments.model_validate(application.args))
