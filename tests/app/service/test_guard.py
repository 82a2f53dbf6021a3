"""The door: keys and rate limits, against a real service."""

import json
import socket
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from prometheus_client.parser import text_string_to_metric_families

from primfit.app.service.guard import OPEN
from primfit.app.service.keys import Keys
from primfit.app.service.rate_limit import RateLimit
from primfit.app.service.server import is_loopback
from primfit.app.wire.problems import RateLimitedError
from tests.app.serving import ALICE, NAMELESS, PATIENCE, running, wait_for
from tests.paths import EXAMPLES

SMALL = json.loads((EXAMPLES / "request.json").read_bytes())
BEARER = {"Authorization": f"Bearer {ALICE}"}


def _is_problem(response: httpx.Response, status: int, slug: str) -> None:
    assert response.status_code == status, response.text
    assert response.json()["type"] == f"urn:primfit:problem:{slug}"
    assert response.json()["instance"] == f"/requests/{response.headers['x-request-id']}"


def _unfinished(port: int, *headers: str) -> bytes:
    """What comes back for the head of a request whose body never comes."""
    lines = ["POST /fit HTTP/1.1", "Host: x", "Content-Type: text/csv", "Content-Length: 1000000", *headers]
    with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) as connection:
        connection.sendall("\r\n".join([*lines, "", ""]).encode())
        return connection.recv(65536)


def test_every_operation_but_the_open_ones_needs_a_key(guarded_service: Any) -> None:
    paths = guarded_service.client.get("/openapi.json").json()["paths"]
    assert {"/fit", "/metrics", "/version", "/capabilities"} <= set(paths)
    for path, operations in paths.items():
        for method in operations:
            response = guarded_service.client.request(method.upper(), path)
            if path in OPEN:
                assert response.status_code == 200
            else:
                _is_problem(response, 401, "unauthorized")
                assert response.headers["www-authenticate"] == 'Bearer realm="primfit"'
    _is_problem(guarded_service.client.get("/nothing/here"), 401, "unauthorized")
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
    _is_problem(response, 401, "unauthorized")
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
    assert b" 401 " in _unfinished(guarded_service.port)


def test_a_large_body_without_a_key_is_answered_and_the_connection_goes_on(guarded_service: Any) -> None:
    for _ in range(3):
        response = guarded_service.post(b"1,2,3\n" * 2_000_000, "text/csv")
        _is_problem(response, 401, "unauthorized")
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
    assert clients == {"alice", "key2"}
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


def test_the_name_of_a_client_says_whose_key_it_is() -> None:
    keys = Keys.read([f"alice:{ALICE}", NAMELESS])
    assert (keys.owner(ALICE), keys.owner(NAMELESS), keys.owner("")) == ("alice", "key2", None)
    assert ALICE not in repr(keys) and not Keys()


@pytest.fixture(scope="module")
def limited(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A service that takes three requests a day of a client, and hears from a proxy who it is."""
    with running(
        tmp_path_factory.mktemp("bodies"),
        workers=1,
        rate_limit="3/day",
        trusted_proxies="127.0.0.1",
        api_keys=ALICE,
    ) as started:
        yield started


def test_a_client_that_asks_too_often_is_told_when_to_come_back(limited: Any) -> None:
    client = {"X-Forwarded-For": "203.0.113.1"}
    for left in (2, 1, 0):
        response = limited.client.get("/docs", headers=client)
        assert response.status_code == 200
        assert response.headers["ratelimit-policy"] == '"client";q=3;w=86400'
        assert response.headers["ratelimit"].startswith(f'"client";r={left};t=')
    refused = limited.client.get("/docs", headers=client)
    _is_problem(refused, 429, "rate-limited")
    assert refused.json()["detail"].startswith("3 requests in 86400 s")
    assert 1 <= int(refused.headers["retry-after"]) <= 86400
    assert limited.client.get("/docs", headers={"X-Forwarded-For": "203.0.113.2"}).status_code == 200
    assert b" 429 " in _unfinished(limited.port, "X-Forwarded-For: 203.0.113.1")


def test_guessing_keys_is_limited_too(limited: Any) -> None:
    client = {"X-Forwarded-For": "203.0.113.3"}
    statuses = [
        limited.client.get("/version", headers={**client, "X-API-Key": f"{number:020}"}).status_code
        for number in range(5)
    ]
    assert statuses == [401, 401, 401, 429, 429]


def test_a_key_has_a_limit_of_its_own_wherever_it_comes_from(limited: Any) -> None:
    statuses = [
        limited.client.get("/version", headers={"X-Forwarded-For": f"203.0.113.{host}", **BEARER}).status_code
        for host in range(10, 14)
    ]
    assert statuses == [200, 200, 200, 429]
    assert limited.client.get("/metrics", headers=BEARER).status_code == 200


def test_probes_are_never_limited(limited: Any) -> None:
    client = {"X-Forwarded-For": "203.0.113.4"}
    for _ in range(5):
        assert limited.client.get("/livez", headers=client).status_code == 200
        assert limited.client.get("/readyz", headers=client).status_code == 200
    assert "ratelimit" not in limited.client.get("/livez").headers


def test_who_the_client_is_is_heard_from_trusted_proxies_only(guarded_service: Any) -> None:
    headers = {"X-Forwarded-For": "203.0.113.9", "X-Request-Id": "not-from-a-proxy"}
    guarded_service.client.get("/version", headers=headers)
    wait_for(lambda: "not-from-a-proxy" in guarded_service.log.read_text())
    (line,) = (line for line in guarded_service.log.read_text().splitlines() if "not-from-a-proxy" in line)
    assert json.loads(line)["address"] == "127.0.0.1"


def test_an_ipv6_client_is_its_network() -> None:
    limit = RateLimit("2/day")
    limit.hit(None, "2001:db8:1:2::3")
    limit.hit(None, "2001:db8:1:2:ffff::4")
    with pytest.raises(RateLimitedError):
        limit.hit(None, "2001:db8:1:2::5")
    limit.hit(None, "2001:db8:1:3::3")
    limit.hit(None, "not an address")


def test_an_ipv4_client_is_its_address_however_written() -> None:
    limit = RateLimit("2/day")
    limit.hit(None, "::ffff:192.0.2.1")
    limit.hit(None, "192.0.2.1")
    with pytest.raises(RateLimitedError):
        limit.hit(None, "::ffff:192.0.2.1")
    limit.hit(None, "::ffff:192.0.2.2")


@pytest.mark.parametrize(
    ("address", "alone"), [("127.0.0.1", True), ("::1", True), ("0.0.0.0", False), ("fe80::1%eth0", False)]
)
def test_which_addresses_others_reach(address: str, alone: bool) -> None:
    assert is_loopback(address) == alone
