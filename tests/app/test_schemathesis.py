"""schemathesis on the whole document, by its file, a thousand cases an operation; `make test-schema`."""

import json
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from tests.paths import ROOT

CASES = 1000

pytestmark = pytest.mark.schema


def test_the_service_keeps_to_its_document(service: Any) -> None:
    report = ROOT / "build" / "schemathesis.ndjson"
    report.parent.mkdir(exist_ok=True)
    url = f"http://127.0.0.1:{service.port}/openapi.json"
    command = [sys.executable, "-m", "schemathesis.cli", "run", url, "--no-color"]
    command += ["--report", "ndjson", "--report-ndjson-path", str(report)]
    done = subprocess.run(command, cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False)
    assert done.returncode == 0
    cases = _cases(report)
    print(*(f"{count} cases of {operation}" for operation, count in sorted(cases.items())), sep="\n")
    methods = service.client.get("/openapi.json").json()["paths"].items()
    assert set(cases) == {f"{method.upper()} {path}" for path, given in methods for method in given}
    assert min(cases.values()) >= CASES


def _cases(report: Path) -> Counter[str]:
    """How many requests each operation got."""
    counts: Counter[str] = Counter()
    for line in report.read_bytes().splitlines():
        scenario = json.loads(line).get("ScenarioFinished")
        if scenario:
            counts[scenario["recorder"]["label"]] += len(scenario["recorder"]["interactions"])
    return counts
