"""Rate limits, by key and by address, against a real service."""

from collections.abc import Iterator
from typing import Any

import pytest

from primfit.app.service.rate_limit import RateLimit
from primfit.app.wire.problems import RateLimitedError
from tests.app.service.asking import BEARER, is_problem, unfinished
from tests.app.serving import ALICE, running


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
    is_problem(refused, 429, "rate-limited")
    assert refused.json()["detail"].startswith("3 requests in 86400 s")
    assert 1 <= int(refused.headers["retry-after"]) <= 86400
    assert limited.client.get("/docs", headers={"X-Forwarded-For": "203.0.113.2"}).status_code == 200
    assert b" 429 " in unfinished(limited.port, "X-Forwarded-For: 203.0.113.1")


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
