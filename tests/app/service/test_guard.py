"""The door: keys, against a real service."""

import json
import socket
from typing import Any

import pytest
from prometheus_client.parser import text_string_to_metric_families

from primfit.app.service.guard import OPEN
from tests.app.service.asking import BEARER, is_problem, unfinished
from tests.app.serving import ALICE, NAMELESS, PATIENCE, wait_for
from tests.paths import EXAMPLES

SMALL = json.loads((EXAMPLES / "request.json").read_bytes())


def test_every_operation_but_the_open_ones_needs_a_key(guarded_service: Any) -> None:
    paths = guarded_service.client.get("/openapi.json").json()["paths"]
    assert {"/fit", "/metrics", "/version", "/capabilities"} <= set(paths)
    for path, operations in paths.items():
        for method in operations:
            response = guarded_service.client.request(method.upper(), path)
            if path in OPEN:
                assert response.status_code == 200
            else:
                is_problem(response, 401, "unauthorized")
                assert response.headers["www-authenticate"] == 'Bearer realm="primfit"'
    is_problem(guarded_service.client.get("/nothing/here"), 401, "unauthorized")
    assert guarded_service.client.get("/docs").status_code == 200


@pytest.mark.parametrize(
    "headers",
    [
        BEARER,
        {"Authorization": f"bearer {ALICE}"},
        {"X-API-Key": NAMELESS},
        {"Authorization": "Basic abc", "X-API-Key": ALICE},
    ],
)
def test_a_key_opens_the_door(guarded_service: Any, headers: dict[str, str]) -> None:
    assert guarded_service.client.post("/fit", json=SMALL, headers=headers).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"Authorization": f"Bearer {ALICE[:-1]}"},
        {"Authorization": f"Bearer {ALICE}x"},
        {"Authorization": f"Bearer alice:{ALICE}"},
        {"Authorization": f"Basic {ALICE}"},
        {"Authorization": "Bearer"},
        {"Authorization": ALICE},
        {"X-API-Key": ""},
        {"X-API-Key": "\xe9" * 20},
    ],
)
def test_what_is_no_key_does_not(guarded_service: Any, headers: dict[str, str]) -> None:
    encoded = {name: value.encode("latin-1") for name, value in headers.items()}
    response = guarded_service.client.post("/fit", json=SMALL, headers=encoded)
    is_problem(response, 401, "unauthorized")
    assert ALICE[:-1] not in response.text


@pytest.mark.parametrize("host", ["x/livez?", "x/docs#", "livez", "x:1/readyz;"])
@pytest.mark.parametrize(
    "path", ["/version", "/version?/livez", "//livez/../version", "/livez%2f..%2fversion"]
)
def test_neither_host_nor_path_gets_around_it(guarded_service: Any, host: str, path: str) -> None:
    with socket.create_connection(("127.0.0.1", guarded_service.port), timeout=PATIENCE) as connection:
        connection.sendall(f"GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n".encode())
        assert b" 401 " in connection.recv(65536).split(b"\r\n")[0]


def test_the_door_is_shut_before_the_body_comes(guarded_service: Any) -> None:
    assert b" 401 " in unfinished(guarded_service.port)


def test_a_client_that_sends_a_large_body_without_a_key_sees_why_it_is_refused(guarded_service: Any) -> None:
    for _ in range(3):
        response = guarded_service.post(b"1,2,3\n" * 2_000_000, "text/csv")
        is_problem(response, 401, "unauthorized")
    assert guarded_service.client.get("/livez").status_code == 200


def test_clients_are_named_in_log_and_metrics_and_their_keys_are_not(guarded_service: Any) -> None:
    guarded_service.client.get(
        "/version", headers={"X-API-Key": ALICE, "X-Request-Id": "a-key-that-is-known"}
    )
    guarded_service.client.get(f"/version?key={NAMELESS}", headers={"X-API-Key": NAMELESS})
    metrics = guarded_service.client.get("/metrics", headers=BEARER).text
    clients = {
        sample.labels["client"]
        for family in text_string_to_metric_families(metrics)
        for sample in family.samples
        if family.name == "primfit_client_requests"
    }
    assert clients == {"alice", "key-3eb1bd43"}
    wait_for(lambda: "a-key-that-is-known" in guarded_service.log.read_text())
    log = guarded_service.log.read_text()
    lines = {line.get("request_id"): line for line in map(json.loads, log.splitlines())}
    assert lines["a-key-that-is-known"]["client"] == "alice"
    for key in (ALICE, NAMELESS):
        assert key not in log and key not in metrics


def test_the_document_says_how_to_send_a_key(guarded_service: Any) -> None:
    document = guarded_service.client.get("/openapi.json").json()
    assert document["security"] == [{}, {"bearer": []}, {"apiKey": []}]
    assert set(document["components"]["securitySchemes"]) == {"bearer", "apiKey"}
    assert {"401", "429"} <= set(document["paths"]["/fit"]["post"]["responses"])
    assert "401" not in document["paths"]["/livez"]["get"]["responses"]


def test_who_the_client_is_is_heard_from_trusted_proxies_only(guarded_service: Any) -> None:
    headers = {"X-Forwarded-For": "203.0.113.9", "X-Request-Id": "not-from-a-proxy"}
    guarded_service.client.get("/version", headers=headers)
    wait_for(lambda: "not-from-a-proxy" in guarded_service.log.read_text())
    (line,) = (line for line in guarded_service.log.read_text().splitlines() if "not-from-a-proxy" in line)
    assert json.loads(line)["address"] == "127.0.0.1"
