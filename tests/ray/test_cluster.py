"""Runs on a real cluster: three nodes on this machine, killed nodes and drivers, and a poison segment.

Drivers are `primfit batch` as people start it.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
pytest.importorskip("ray", reason="needs the extra ray: make test-ray")
parquet = pytest.importorskip("pyarrow.parquet", reason="needs the extra bulk: make test-ray")

import primfit
from primfit.app.bulk.parts import part_files
from primfit.app.bulk.run import POISON
from primfit.fitting.primitives.sphere import Sphere
from tests.app.bulk.poison import Poison
from tests.ray.clusters import cluster_of, kill_node

# Ray leaves files and processes to the end of its own.
pytestmark = [pytest.mark.ray, pytest.mark.filterwarnings("default")]

N = 1500
SLEEP = 0.05


@pytest.fixture(scope="module")
def clouds(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("clouds")
    rng = np.random.default_rng(0)
    for number in range(N):
        azimuth, polar = rng.uniform(0, 3, (2, 60))
        points = Sphere(np.array([1.0, 2.0, 3.0]), rng.uniform(1, 9)).surface(azimuth, polar)
        np.savetxt(folder / f"{number:05}.csv", points, delimiter=",", fmt="%.17g")
    return folder


@pytest.fixture(scope="module")
def local(clouds: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run by processes of this machine."""
    out = tmp_path_factory.mktemp("local")
    subprocess.run([*driver(clouds, out), "--workers", "2"], check=True, timeout=600)
    return out


@pytest.fixture
def cluster() -> Iterator[Any]:
    with cluster_of(3) as made:
        yield made


def driver(clouds: Path, out: Path) -> list[str]:
    given = ["batch", str(clouds), "--out", str(out), "--format", "parquet"]
    return [sys.executable, "-m", "primfit", *given]


def on(cluster: Any) -> list[str]:
    return ["--executor", "ray", "--address", cluster.address]


def parts(out: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in part_files(out)}


def wait_for_parts(out: Path, n: int, process: subprocess.Popen[bytes]) -> None:
    while len(part_files(out)) < n:
        assert process.poll() is None, "it ended before"
        time.sleep(SLEEP)


def test_every_segment_once_and_the_same_while_a_node_is_killed(
    clouds: Path, local: Path, cluster: Any, tmp_path: Path
) -> None:
    with subprocess.Popen([*driver(clouds, tmp_path), *on(cluster)]) as process:
        wait_for_parts(tmp_path, 1, process)
        kill_node(cluster)
        assert process.wait(timeout=600) == 0
    assert parts(tmp_path) == parts(local)
    ids = parquet.read_table([str(file) for file in part_files(tmp_path)])["id"].to_pylist()
    assert len(ids) == len(set(ids)) == N


def test_a_driver_that_is_killed_is_started_again_and_does_nothing_twice(
    clouds: Path, local: Path, cluster: Any, tmp_path: Path
) -> None:
    with subprocess.Popen([*driver(clouds, tmp_path), *on(cluster)]) as process:
        wait_for_parts(tmp_path, 2, process)
        process.kill()
    time.sleep(2)  # those that it left at work end
    before = {file: file.stat().st_mtime_ns for file in part_files(tmp_path)}
    assert 0 < len(before) < len(parts(local))
    subprocess.run([*driver(clouds, tmp_path), *on(cluster)], check=True, timeout=600)
    assert {file: file.stat().st_mtime_ns for file in before} == before
    assert parts(tmp_path) == parts(local)
    manifest = json.loads((tmp_path / "_primfit" / "manifest.json").read_bytes())
    assert manifest["complete"]


def test_a_poison_segment_is_a_row_and_a_cloud_is_cut_on_the_cluster(cluster: Any, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    points = rng.normal(size=(30, 200, 3))
    points /= np.linalg.norm(points, axis=2, keepdims=True)
    folder = tmp_path / "clouds"
    folder.mkdir()
    for number, cloud in enumerate(points):
        np.savetxt(folder / f"{number:02}.csv", cloud, delimiter=",", fmt="%.17g")
    (folder / "07.csv").unlink()
    poison = Poison(folder / "07.csv", 5)
    poison.start()
    names = tmp_path / "names.txt"
    names.write_text("".join(f"{folder / f'{number:02}.csv'}\n" for number in range(30)))
    command = [sys.executable, "-m", "primfit", "batch", f"@{names}", "--out", str(tmp_path / "out")]
    done = subprocess.run([*command, "--format", "parquet", *on(cluster)], timeout=300, check=False)
    assert done.returncode == 2 and len(set(poison.killed)) == 4
    [file] = part_files(tmp_path / "out")
    rows = parquet.read_table(str(file)).to_pylist()
    assert [row["status"] for row in rows] == ["fitted"] * 7 + ["problem"] + ["fitted"] * 22
    assert rows[7]["message"] == POISON

    labels = np.repeat(np.arange(30), 200)
    here = primfit.fit_segments(points.reshape(-1, 3), labels)
    there = primfit.fit_segments(points.reshape(-1, 3), labels, executor="ray", address=cluster.address)
    assert [each.to_json() for each in there] == [each.to_json() for each in here]
