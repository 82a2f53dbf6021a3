"""Jobs of a service on a cluster of three machines: the same lines, also where one is lost, or all are."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
pytest.importorskip("ray", reason="needs the extra ray: make test-ray")

from primfit.benchmark.scaling.cluster import cluster as nodes_here
from primfit.benchmark.scaling.cluster import kill_node
from primfit.fitting.primitives.sphere import Sphere
from tests.app.serving import Service, running, wait_for

# Ray leaves files and processes to the end of its own.
pytestmark = [pytest.mark.ray, pytest.mark.filterwarnings("default")]

N = 600
CSV = {"Content-Type": "text/csv", "X-Request-Id": "scan"}


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with nodes_here() as made:
        yield made


@pytest.fixture
def asked(cluster: Any, tmp_path: Path) -> dict[str, object]:
    """The settings of a service whose jobs are done on the cluster."""
    jobs = {"jobs_path": tmp_path / "jobs", "jobs_executor": "ray", "jobs_address": cluster.address}
    return {"workers": 1, **jobs}


@pytest.fixture
def body() -> bytes:
    """A scan of so many segments, of which one has too few points."""
    rng = np.random.default_rng(0)
    rows = ["x,y,z,label"]
    for label in range(N):
        n_points = 2 if label == 7 else 300
        azimuth, polar = rng.uniform(0, 3, (2, n_points))
        points = Sphere(np.array([1.0, 2.0, 3.0]), rng.uniform(1, 9)).surface(azimuth, polar)
        rows += [f"{x:.17g},{y:.17g},{z:.17g},{label}" for x, y, z in points]
    return "\n".join(rows).encode()


def hand_in(service: Service, body: bytes) -> str:
    response = service.client.post("/jobs", content=body, headers=CSV)
    assert response.status_code == 202
    return str(response.json()["jobID"])


def state(service: Service, job: str) -> dict[str, Any]:
    found: dict[str, Any] = service.client.get(f"/jobs/{job}").json()
    return found


def test_the_lines_are_the_same_while_a_machine_is_lost(
    cluster: Any, asked: dict[str, object], body: bytes, tmp_path: Path
) -> None:
    with running(tmp_path / "service", **asked) as service:
        local = service.client.post("/fit/batch", content=body, headers=CSV).content
        job = hand_in(service, body)
        wait_for(lambda: state(service, job)["progress"] > 0)
        kill_node(cluster)
        assert state(service, job)["status"] == "running"
        wait_for(lambda: state(service, job)["status"] != "running")
        assert service.client.get(f"/jobs/{job}/results?limit=10000").content == local
        assert [b'"problem":' in line for line in local.splitlines()].index(True) == 7
        assert not list((tmp_path / "jobs" / "jobs" / job).glob("primfit-*")), "nothing temporary stays"


def test_a_job_is_canceled_and_the_service_outlives_the_cluster(
    cluster: Any, asked: dict[str, object], body: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RAY_gcs_rpc_server_reconnect_timeout_s", "3")
    with running(tmp_path / "service", **asked) as service:
        job = hand_in(service, body)
        wait_for(lambda: state(service, job)["lines"] > 0)
        assert service.client.delete(f"/jobs/{job}").json()["status"] == "dismissed"
        wait_for(lambda: "a job was canceled" in service.log.read_text())
        assert state(service, job)["lines"] < N

        job = hand_in(service, body)
        wait_for(lambda: state(service, job)["lines"] > 0)
        cluster.shutdown()
        wait_for(lambda: "the cluster is lost" in service.log.read_text())
        assert state(service, job)["status"] == "running"
        assert service.post(body, "text/csv").status_code == 200
