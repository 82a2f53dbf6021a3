"""Real services in processes of their own, once a session: one as it comes, a strict and a guarded one."""

from collections.abc import Iterator

import numpy as np
import pytest

from tests.app import npm
from tests.app.serving import ALICE, NAMELESS, Service, running
from tests.paths import EXAMPLES


@pytest.fixture(scope="session")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with the default limits, which keeps jobs."""
    jobs = tmp_path_factory.mktemp("jobs")
    with running(tmp_path_factory.mktemp("bodies"), workers=2, jobs_path=jobs) as started:
        yield started


@pytest.fixture(scope="session")
def strict_service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with one worker, 1 MiB, 20,000 points, 1,000 in JSON, and three seconds for everything."""
    limits = {"max_body_bytes": 2**20, "max_points": 20_000, "max_json_points": 1000}
    times = {"fit_time_limit": 3.0, "receive_timeout": 3.0, "queue_size": 1}
    with running(tmp_path_factory.mktemp("bodies"), workers=1, **limits, **times) as started:
        yield started


@pytest.fixture(scope="session")
def guarded_service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service that asks for a key, has one worker and jobs, logs in JSON, and takes any name of a host."""
    told = {"api_keys": f"alice:{ALICE},{NAMELESS}", "log_format": "json", "allowed_hosts": "*"}
    told["jobs_path"] = str(tmp_path_factory.mktemp("jobs"))
    with running(tmp_path_factory.mktemp("bodies"), workers=1, **told) as started:
        yield started


@pytest.fixture(scope="session")
def viewer_sources() -> None:
    """The sources of the viewer with the packages of their lock file, in `npm.VIEWER`."""
    npm.install_viewer()


@pytest.fixture(scope="session")
def cylinder() -> np.ndarray:
    """The points of the bundled example."""
    return np.loadtxt(EXAMPLES / "cylinder.csv", delimiter=",", skiprows=2)
