"""What the metrics tell of a request, on a real service."""

import json
import os
import re
import signal
from pathlib import Path
from typing import Any

import pytest
from prometheus_client.parser import text_string_to_metric_families

from primfit.app.service.metrics import Metrics
from tests.app.serving import ALICE, workers
from tests.paths import DOCS, EXAMPLES

CSV = (EXAMPLES / "cylinder.csv").read_bytes()
SMALL = json.loads((EXAMPLES / "request.json").read_bytes())
KEY = {"X-API-Key": ALICE}


def _samples(service: Any) -> dict[tuple[str, ...], float]:
    """Each sample of the metrics by its name and the values of its labels."""
    text = service.client.get("/metrics", headers=KEY).text
    return {
        (sample.name, *(value for _, value in sorted(sample.labels.items()))): sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


def test_metrics_count_what_happened(guarded_service: Any) -> None:
    before = _samples(guarded_service)
    headers = {**KEY, "Content-Type": "text/csv"}
    answer = guarded_service.client.post("/fit", content=CSV, headers=headers).json()
    refused = guarded_service.client.post(
        "/fit?kinds=sphere&kinds=torus", content=CSV, headers=headers
    ).json()
    guarded_service.client.post("/fit", content=b"one,1\n", headers=headers)
    n_attempts = len(answer["attempts"]) + len(refused["attempts"])
    after = _samples(guarded_service)
    grown = {name: value - before.get(name, 0.0) for name, value in after.items()}
    kind = refused["primitive"]["kind"]
    assert grown["primfit_answers_total", "cylinder", "fitted"] == 1
    assert grown["primfit_answers_total", kind, refused["status"]] == 1
    assert grown["primfit_fit_seconds_count", "cylinder"] == 1
    assert grown["primfit_cloud_points_sum",] == 600
    assert grown["primfit_refinements_total",] == n_attempts
    assert grown["primfit_backtracks_total",] == n_attempts - 2
    assert grown["primfit_problems_total", "unreadable-input"] == 1
    assert grown["primfit_request_seconds_count", "/fit", "200"] == 2
    assert grown["primfit_request_seconds_count", "/fit", "422"] == 1
    assert grown["primfit_received_bytes_total", "/fit"] == 2 * len(CSV) + len(b"one,1\n")
    assert grown["primfit_client_requests_total", "alice"] == 4  # these three, and reading the first time
    assert after["primfit_workers_warm",] == 1
    assert after["primfit_workers_busy",] == after["primfit_queue_length", "small"] == 0


def test_the_metrics_shown_are_metrics_that_there_are(guarded_service: Any) -> None:
    guarded_service.client.post("/fit", json=SMALL, headers=KEY)
    shown = text_string_to_metric_families((EXAMPLES / "metrics.txt").read_text())
    there = _samples(guarded_service)
    for family in shown:
        for sample in family.samples:
            assert (sample.name, *(value for _, value in sorted(sample.labels.items()))) in there
    response = guarded_service.client.get("/metrics", headers=KEY)
    assert response.headers["content-type"].startswith("text/plain; version=0.0.4")


def test_the_page_names_metrics_that_there_are(guarded_service: Any) -> None:
    text = guarded_service.client.get("/metrics", headers=KEY).text
    page = (DOCS / "operations.md").read_text()
    assert len(named := set(re.findall(r"primfit_\w+", page))) > 15
    assert all(name in text for name in named)


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="finds the workers in /proc")
def test_a_worker_started_again_is_counted(guarded_service: Any) -> None:
    before = _samples(guarded_service)["primfit_worker_restarts_total",]
    (worker,) = workers(guarded_service.pid)
    os.kill(worker, signal.SIGKILL)
    assert guarded_service.client.post("/fit", json=SMALL, headers=KEY).status_code == 200
    assert _samples(guarded_service)["primfit_worker_restarts_total",] == before + 1


def test_each_application_counts_for_itself() -> None:
    one, other = Metrics(), Metrics()
    one.answered({"fit_status": "no_fit", "fit_kind": None, "n_points": 3, "attempts": 0, "fit_seconds": 0.1})
    assert b'primfit_answers_total{kind="none",status="no_fit"} 1.0' in one.text()
    assert b"primfit_backtracks_total 0.0" in one.text()
    assert b"primfit_answers_total{" not in other.text()
