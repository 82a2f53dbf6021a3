"""One input of one target, and everything that must hold whatever it is."""

import resource
import sys
import time

import numpy as np

from primfit.app.readers import Cloud, InvalidPointsError, without_missing
from primfit.app.wire.problems import problem
from tests.fuzz.targets import LIMITS, TARGETS

CPU_SECONDS = 1.0
"""Of the processor, for one input: what others do on the machine does not count."""

MEGABYTES = 200
"""Beyond what the process held before the first input."""


def check(name: str, data: bytes) -> None:
    """Read the input; `AssertionError` where it costs too much, or what comes out is not as it should be."""
    before, started = peak(), time.process_time()
    try:
        cloud = TARGETS[name](data)
    except Exception as error:
        refused = problem(error, "/requests/fuzz")
        if refused.status >= 500:
            raise
        assert len(refused.content) <= 24 * 1024
        cloud = None
    cpu_seconds, megabytes = time.process_time() - started, (peak() - before) / 2**20
    assert cpu_seconds <= CPU_SECONDS, f"it took {cpu_seconds:.2f} s of the processor"
    assert megabytes <= MEGABYTES, f"it took {megabytes:.0f} MB"
    if cloud is not None:
        _check_cloud(cloud)


def _check_cloud(cloud: Cloud) -> None:
    points = cloud.points
    assert points.dtype == np.float64 and points.ndim == 2 and points.shape[1] == 3
    assert LIMITS.points is not None and len(points) <= LIMITS.points
    assert cloud.normals is None or cloud.normals.shape == points.shape
    assert cloud.labels is None or cloud.labels.shape == points.shape[:1]
    try:
        kept = without_missing(cloud)
    except InvalidPointsError:
        return
    assert np.isfinite(kept.points).all()
    if kept.normals is not None:
        np.testing.assert_allclose(np.linalg.norm(kept.normals, axis=1), 1.0, rtol=1e-6)


def peak() -> int:
    """Most bytes that this process ever held in memory."""
    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
