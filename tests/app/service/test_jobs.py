"""Jobs over HTTP against real services: what is handed in comes back once, with the bytes of a batch."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urljoin

import httpx
import pytest

from primfit.app.wire.job_schemas import JobList, JobStatus
from tests.app.processes import needs_proc
from tests.app.service.asking import BEARER, is_problem
from tests.app.service.scans import many
from tests.app.serving import NAMELESS, PATIENCE, Service, running, wait_for, workers
from tests.paths import EXAMPLES

SEGMENTS = (EXAMPLES / "segments.csv").read_bytes()
CSV = {"Content-Type": "text/csv", "X-Request-Id": "job-1"}


def hand_in(service: Service, body: bytes, **headers: str) -> str:
    """The path of a new job."""
    response = service.client.post("/jobs", content=body, headers=CSV | headers)
    assert response.status_code == 202, response.text
    job = JobStatus.model_validate(response.json())
    path = response.url.join(response.headers["location"]).path
    assert path == response.url.join(job.links[0].href).path == f"/jobs/{job.jobID}"
    return path


def status(service: Service, path: str) -> dict[str, Any]:
    response = service.client.get(path)
    assert response.status_code == 200, response.text
    JobStatus.model_validate(response.json())
    found: dict[str, Any] = response.json()
    return found


def ended(service: Service, path: str, patience: float = PATIENCE) -> dict[str, Any]:
    """The status of a job when it has ended."""
    wait_for(lambda: status(service, path)["status"] not in ("accepted", "running"), patience)
    return status(service, path)


def results(service: Service, path: str, limit: int = 1000) -> bytes:
    """All pages of the results of a job that has ended, by their links."""
    content, following = b"", f"{path}/results?limit={limit}"
    while following:
        page = service.client.get(following)
        assert page.status_code == 200
        assert page.headers["content-type"] == "application/x-ndjson"
        content += page.content
        link = page.links.get("next")
        following = str(page.url.join(link["url"])) if link else ""
    return content


def batch(service: Service, body: bytes) -> bytes:
    """The same by `POST /fit/batch`."""
    return service.client.post("/fit/batch", content=body, headers=CSV).content


def events(service: Service, path: str, last: str | None = None) -> list[dict[str, str]]:
    """The events of a job to its end."""
    headers = {} if last is None else {"Last-Event-ID": last}
    with service.client.stream("GET", f"{path}/events", headers=headers) as response:
        assert response.headers["content-type"].startswith("text/event-stream")
        blocks = response.read().decode().strip().split("\n\n")
    fields = [dict(line.split(": ", 1) for line in block.split("\n")) for block in blocks]
    return [block for block in fields if "event" in block]


@pytest.fixture(scope="module")
def done(service: Service) -> str:
    """The path of a job that has ended."""
    path = hand_in(service, SEGMENTS)
    ended(service, path)
    return path


def test_a_job_brings_the_lines_of_a_batch(service: Service, done: str) -> None:
    job = status(service, done)
    assert (job["status"], job["progress"], job["files"], job["lines"]) == ("successful", 100, 1, 4)
    assert job["summary"]["items"] == 3
    assert job["created"] <= job["started"] <= job["finished"] < job["expires"]
    expected = batch(service, SEGMENTS)
    assert results(service, done) == results(service, done, limit=1) == results(service, done, 3) == expected
    part = service.client.get(f"{done}/results", params={"offset": 1, "limit": 2})
    assert part.content.splitlines() == expected.splitlines()[1:3]
    assert service.client.get(f"{done}/results", params={"offset": 9}).content == b""


@pytest.mark.parametrize("prefix", ["", "/tools/primfit"])
def test_links_hold_behind_a_prefix_that_a_proxy_takes_away(service: Service, prefix: str) -> None:
    def ask(method: str, path: str, **given: Any) -> tuple[httpx.Response, Callable[[str], str]]:
        """The answer through a proxy, and where a client finds what stands in it."""
        response = service.client.request(method, path, **given)
        return response, lambda link: urljoin(f"https://example.com{prefix}{path}", link)

    for asked in ("/jobs", "/fit/batch"):
        headers = CSV | {"Prefer": "respond-async"}
        response, seen = ask("POST", asked, content=SEGMENTS, headers=headers)
        job_id = response.json()["jobID"]
        path, whole = f"/jobs/{job_id}", f"https://example.com{prefix}/jobs/{job_id}"
        everything = [whole, f"{whole}/results", f"{whole}/events"]
        assert seen(response.headers["location"]) == whole
        assert [seen(link["href"]) for link in response.json()["links"]] == everything
    ended(service, path)
    response, seen = ask("GET", path)
    assert [seen(link["href"]) for link in response.json()["links"]] == everything
    response, seen = ask("GET", "/jobs")
    assert [seen(link["href"]) for link in response.json()["jobs"][-1]["links"]] == everything
    assert seen(response.json()["links"][0]["href"]) == f"https://example.com{prefix}/jobs"
    response, seen = ask("GET", f"{path}/results?limit=1")
    assert seen(response.links["next"]["url"]) == f"{whole}/results?offset=1&limit=1"
    told, seen = events(service, path), ask("HEAD", f"{path}/events")[1]
    assert [seen(link["href"]) for link in json.loads(told[-1]["data"])["links"]] == everything


def test_a_list_has_the_jobs_of_the_client(service: Service, done: str) -> None:
    listed = JobList.model_validate(service.client.get("/jobs").json())
    assert done.rpartition("/")[2] in [job.jobID for job in listed.jobs]


def test_events_tell_each_line_once_and_how_it_ended(service: Service, done: str) -> None:
    lines = batch(service, SEGMENTS).decode().splitlines()
    path = hand_in(service, SEGMENTS)
    told = events(service, path)
    assert [event["data"] for event in told if event["event"] == "result"] == lines
    assert [event["id"] for event in told if event["event"] == "result"] == ["1", "2", "3", "4"]
    assert told[-1]["id"] == "end" and '"status":"successful"' in told[-1]["data"]
    rest = [event["data"] for event in events(service, path, "3") if event["event"] == "result"]
    assert rest == lines[3:]
    assert service.client.head(f"{path}/events").headers["content-type"].startswith("text/event-stream")
    nothing = service.client.get(f"{path}/events", headers={"Last-Event-ID": "end"})
    assert nothing.status_code == 204
    is_problem(service.client.get(f"{path}/events", headers={"Last-Event-ID": "x"}), 422, "invalid-options")


def test_the_same_key_brings_the_same_job(service: Service) -> None:
    path = hand_in(service, SEGMENTS, **{"Idempotency-Key": '"a b"'})
    assert hand_in(service, SEGMENTS, **{"Idempotency-Key": "a b"}) == path
    assert hand_in(service, SEGMENTS) != path
    headers = CSV | {"Idempotency-Key": "a b"}
    other = service.client.post("/jobs?seed=1", content=SEGMENTS, headers=headers)
    is_problem(other, 422, "idempotency-key-reused")
    other = service.client.post("/jobs", content=SEGMENTS, headers=CSV | {"Idempotency-Key": "x" * 256})
    is_problem(other, 422, "invalid-options")


def test_a_batch_becomes_a_job_where_the_client_prefers_one(service: Service) -> None:
    headers = CSV | {"Prefer": 'handling=lenient, Respond-Async; foo="1", wait=10'}
    response = service.client.post("/fit/batch", content=SEGMENTS, headers=headers)
    assert response.status_code == 202
    assert response.headers["preference-applied"] == "respond-async"
    path = response.url.join(response.headers["location"]).path
    assert ended(service, path)["status"] == "successful"


@pytest.mark.parametrize(
    ("body", "query", "code", "slug"),
    [
        (b"", "", 422, "unreadable-input"),
        (SEGMENTS, "?kind=plane", 422, "invalid-options"),
        (SEGMENTS, "?max_error=7", 422, "invalid-options"),
    ],
)
def test_what_a_batch_is_refused_for_a_job_is_refused_for(
    service: Service, body: bytes, query: str, code: int, slug: str
) -> None:
    n_before = len(service.client.get("/jobs").json()["jobs"])
    is_problem(service.client.post(f"/jobs{query}", content=body, headers=CSV), code, slug)
    assert len(service.client.get("/jobs").json()["jobs"]) == n_before


@pytest.mark.parametrize("query", ["offset=-1", "limit=0", "limit=10001", "offset=x", "limit=1&limit=2"])
def test_pages_are_asked_for_by_numbers(service: Service, done: str, query: str) -> None:
    is_problem(service.client.get(f"{done}/results?{query}"), 422, "invalid-options")


def test_a_job_is_canceled_and_then_removed(service: Service) -> None:
    path = hand_in(service, many(300))
    wait_for(lambda: status(service, path)["lines"] > 0)
    assert service.client.get(f"{path}/results").links["next"]
    canceled = service.client.delete(path).json()
    assert (canceled["status"], canceled["progress"] < 100) == ("dismissed", True)
    n_lines = canceled["lines"]
    assert len(results(service, path).splitlines()) == n_lines
    time.sleep(1.5)
    assert status(service, path)["lines"] == n_lines
    assert service.client.delete(path).json()["status"] == "dismissed"
    for gone in (path, f"{path}/results", f"{path}/events"):
        is_problem(service.client.get(gone), 404, "no-such-job")
    is_problem(service.client.delete(path), 404, "no-such-job")


def test_a_job_belongs_to_its_key(guarded_service: Service) -> None:
    url = f"http://127.0.0.1:{guarded_service.port}"
    with (
        httpx.Client(base_url=url, headers=BEARER, timeout=PATIENCE) as alice,
        httpx.Client(base_url=url, headers={"X-API-Key": NAMELESS}, timeout=PATIENCE) as other,
    ):
        response = alice.post("/jobs", content=SEGMENTS, headers=CSV | {"Idempotency-Key": "k"})
        path = response.headers["location"]
        is_problem(guarded_service.client.get(path), 401, "unauthorized")
        for gone in (other.get(path), other.get(f"{path}/results"), other.get(f"{path}/events")):
            is_problem(gone, 404, "no-such-job")
        is_problem(other.delete(path), 404, "no-such-job")
        assert other.get("/jobs").json()["jobs"] == []
        theirs = other.post("/jobs", content=SEGMENTS, headers=CSV | {"Idempotency-Key": "k"})
        assert theirs.headers["location"] != path
        assert alice.get(path).status_code == 200


def test_a_service_without_jobs_says_so(strict_service: Service) -> None:
    is_problem(strict_service.client.get("/jobs"), 404, "jobs-off")
    is_problem(strict_service.client.post("/jobs", content=SEGMENTS, headers=CSV), 404, "jobs-off")
    headers = CSV | {"Prefer": "respond-async"}
    assert strict_service.client.post("/fit/batch", content=SEGMENTS, headers=headers).status_code == 200


def test_a_service_without_jobs_imports_nothing_for_them() -> None:
    names = "{'sqlalchemy', 'psycopg', 'sqlite3'}"
    script = f"import sys, primfit.app.service.server; print(sorted({names} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_a_temporary_directory_that_is_gone_for_a_while_fails_no_job(tmp_path: Path) -> None:
    directory, aside = tmp_path / "service", tmp_path / "aside"
    with running(directory, workers=1, jobs_path=tmp_path / "jobs") as service:
        directory.rename(aside)
        large = service.client.post("/fit", content=b"x" * 3_000_000, headers=CSV)
        is_problem(large, 507, "no-space")
        assert "temporary files cannot be written now (No such file" in large.json()["detail"]
        path = hand_in(service, SEGMENTS)
        wait_for(lambda: "jobs wait" in service.log.read_text())
        assert status(service, path)["status"] == "running"
        aside.rename(directory)
        assert ended(service, path)["status"] == "successful"
        assert results(service, path) == batch(service, SEGMENTS)


@pytest.fixture
def two(tmp_path: Path) -> Iterator[tuple[Service, Service]]:
    """Two services on one folder, with one worker each and few jobs for each client."""
    settings: dict[str, Any] = {"workers": 1, "jobs_path": tmp_path / "jobs", "jobs_per_client": 2}
    with running(tmp_path / "one", **settings) as one, running(tmp_path / "two", **settings) as other:
        yield one, other


@needs_proc
def test_a_job_outlives_its_worker_and_its_service(two: tuple[Service, Service]) -> None:
    one, other = two
    body = many(60)
    path = hand_in(one, body)
    waiting = hand_in(other, SEGMENTS)
    is_problem(one.client.post("/jobs", content=SEGMENTS, headers=CSV), 429, "too-many-jobs")
    wait_for(lambda: status(other, path)["lines"] > 0)
    for service in two:
        for worker in workers(service.pid):
            os.kill(worker, signal.SIGKILL)
    wait_for(lambda: status(other, path)["lines"] > 10)
    os.kill(one.pid, signal.SIGKILL)
    assert ended(other, path)["status"] == ended(other, waiting)["status"] == "successful"
    assert results(other, path) == batch(other, body)
    assert results(other, waiting) == batch(other, SEGMENTS)
