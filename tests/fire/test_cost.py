"""What the service adds to reading and fitting a small cloud."""

from pathlib import Path

import numpy as np
import pytest

from tests.app.processes import needs_proc
from tests.fire.cost import ADDED, N_REQUESTS, added, connected
from tests.fire.report import reported
from tests.paths import ROOT

pytestmark = [pytest.mark.fire, needs_proc]


def test_the_service_adds_little(tmp_path: Path) -> None:
    with reported("added") as figures, connected(tmp_path, ROOT) as (connection,):
        milliseconds = added(connection)
        figures.note("requests", N_REQUESTS)
        figures.note("added, p95", float(np.quantile(milliseconds, 0.95)), "ms")
        figures.at_most("added, median", float(np.median(milliseconds)), ADDED, "ms", clock=True)
