"""Connections that are slow, large, many, or not HTTP: each ends in time, and the others are served."""

import json
import logging
import resource
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import httpx
import pytest

from primfit.app.service.pace import Pace
from primfit.app.service.settings import Settings
from primfit.app.workers.logs import Once
from tests.app.processes import needs_proc, ticks
from tests.app.service.connections import (
    GET,
    POST,
    answer,
    connected,
    one_answer,
    rest,
    sent_until_closed,
    statuses,
)
from tests.app.service.scans import many
from tests.app.service.test_jobs import ended, hand_in
from tests.app.serving import ALICE, PATIENCE, Service, running, wait_for
from tests.paths import EXAMPLES

CSV = (EXAMPLES / "cylinder.csv").read_bytes()
MIB = 2**20
HEAD = 32 * 1024
PLACES = 8
SOON = 10.0
"""Seconds, where one is meant: the machine may have other work."""


@pytest.fixture(scope="module")
def hasty(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service that waits a second for everything, and has few places."""
    times = ("first_byte", "head", "keep_alive", "receive", "send")
    settings: dict[str, Any] = {f"{name}_timeout": 1.0 for name in times} | {"transfer_time_limit": 4.0}
    folder = tmp_path_factory.mktemp("bodies")
    with running(folder, workers=1, max_connections=PLACES, log_format="json", **settings) as started:
        yield started


@pytest.fixture(scope="module")
def patient(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service that has few places, and the times that it has by default, and keeps jobs."""
    folder, jobs = tmp_path_factory.mktemp("bodies"), tmp_path_factory.mktemp("jobs")
    with running(folder, workers=1, max_connections=PLACES, jobs_path=jobs) as started:
        yield started


def _problem(answered: bytes, status: int, slug: str) -> dict[str, Any]:
    """The document of a refusal, which is the last answer on its connection."""
    head, _, body = answered.rpartition(b"\r\n\r\n")
    head = head[head.rindex(b"HTTP/1.1 ") :]
    document: dict[str, Any] = json.loads(body)
    assert head.startswith(b"HTTP/1.1 %d " % status), head
    assert document["type"] == f"urn:primfit:problem:{slug}" and document["status"] == status
    told = dict(line.lower().split(b": ", 1) for line in head.split(b"\r\n")[1:])
    assert told[b"connection"] == b"close"
    assert told[b"content-type"] == b"application/problem+json"
    assert told[b"x-content-type-options"] == b"nosniff"
    assert document["instance"] == f"/requests/{told[b'x-request-id'].decode()}"
    return document


def _memory(pid: int, name: str) -> float:
    """A figure of a process, in MiB."""
    (line,) = (
        line for line in Path(f"/proc/{pid}/status").read_text().splitlines() if line.startswith(f"{name}:")
    )
    return int(line.split()[1]) / 1024


# Heads.


@pytest.mark.parametrize(
    "head",
    [
        b"GET /" + b"a" * HEAD,
        b"GET /livez HTTP/1.1\r\nHost: localhost\r\nX-A: " + b"a" * HEAD,
        b"GET /livez HTTP/1.1\r\nHost: localhost\r\n" + b"X-A: aaaaaaaaaaaaaaaaaaaaaaaaaaaaa\r\n" * 1000,
        b"\r\n" * HEAD,
    ],
    ids=["a path", "a value", "lines", "nothing"],
)
def test_a_head_over_32_kib_is_refused(hasty: Service, head: bytes) -> None:
    assert "32768 bytes" in _problem(answer(hasty.port, head), 431, "head-too-large")["detail"]


def test_a_head_of_32_kib_is_answered(hasty: Service) -> None:
    """To the byte, also where it comes in pieces."""
    begun = b"GET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nX-A: "
    head = begun + b"a" * (HEAD - len(begun) - 4) + b"\r\n\r\n"
    assert statuses(answer(hasty.port, head)) == [200]
    with connected(hasty.port, head[:20_000]) as connection:
        time.sleep(0.1)
        connection.sendall(head[20_000:])
        assert statuses(rest(connection)) == [200]
    assert statuses(answer(hasty.port, head.replace(b"X-A: ", b"X-A: a"))) == [431]


@pytest.mark.parametrize(("n_headers", "status"), [(100, 200), (101, 431)])
def test_100_headers_are_the_limit(hasty: Service, n_headers: int, status: int) -> None:
    head = b"GET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + b"a:b\r\n" * (n_headers - 2)
    assert statuses(answer(hasty.port, head + b"\r\n")) == [status]


@needs_proc
def test_a_head_of_250_mb_leaves_nothing_in_memory(hasty: Service) -> None:
    hasty.client.get("/livez")
    before = _memory(hasty.pid, "VmHWM")
    for line in (b"X-A: " + b"a" * 100 + b"\r\n", b"a"):
        with connected(hasty.port, b"GET /livez HTTP/1.1\r\nX-A: ") as connection:
            # What the buffers of both sides hold, and the mebibyte that is read after the answer.
            assert sent_until_closed(connection, line * (MIB // len(line)), SOON) < 64 * MIB
    assert _memory(hasty.pid, "VmHWM") < before + 10


def test_a_head_that_does_not_come_is_answered_and_closed(hasty: Service) -> None:
    with connected(hasty.port) as connection:
        start = time.monotonic()
        for byte in GET[:6]:
            connection.sendall(bytes([byte]))
            time.sleep(0.1)
        assert "within 1 s" in _problem(rest(connection), 408, "head-timeout")["detail"]
        assert time.monotonic() - start < SOON


@pytest.mark.parametrize("first", [b"", GET], ids=["before the first byte", "between requests"])
def test_idle_connections_are_closed(hasty: Service, first: bytes) -> None:
    with connected(hasty.port, first) as connection:
        start = time.monotonic()
        assert statuses(rest(connection)) == ([200] if first else [])
        assert 0.9 < time.monotonic() - start < SOON


# What is not HTTP, or could be read in two ways.

CHUNKED = b"Transfer-Encoding: chunked\r\n"
SMUGGLED = b"0\r\n\r\nGET /version HTTP/1.1\r\nHost: localhost\r\n\r\n"
AMBIGUOUS = {
    "a length and chunks": b"Content-Length: %d\r\n" % len(SMUGGLED) + CHUNKED,
    "chunks and a length": CHUNKED + b"Content-Length: %d\r\n" % len(SMUGGLED),
    "two lengths": b"Content-Length: 5\r\nContent-Length: 6\r\n",
    "two lengths in one": b"Content-Length: 5, 6\r\n",
    "a length with a sign": b"Content-Length: +5\r\n",
    "a length that is none": b"Content-Length: five\r\n",
    "chunks that are not last": b"Transfer-Encoding: chunked, identity\r\n",
    "chunks by another name": b"Transfer-Encoding: xchunked\r\n",
    "a space before the colon": b"Transfer-Encoding : chunked\r\n",
    "a folded line": b"Transfer-Encoding:\r\n chunked\r\n",
    "a line that is none": b"Transfer-Encoding\r\n" + CHUNKED,
    "a lone line feed": b"X-A: b\nTransfer-Encoding: chunked\r\n",
    "a zero byte": b"X-A: b\0\r\n" + CHUNKED,
}


@pytest.mark.parametrize("headers", AMBIGUOUS.values(), ids=AMBIGUOUS)
def test_a_body_whose_end_is_not_certain_is_refused(hasty: Service, headers: bytes) -> None:
    answered = answer(hasty.port, POST + headers + b"\r\n" + SMUGGLED)
    _problem(answered, 400, "malformed-request")
    assert len(statuses(answered)) == 1


@pytest.mark.parametrize(
    "body", [b"5\r\n1,2,3\r\n-1\r\n", b"xyz\r\n", b"fffffffffffffffff\r\n", b"3\r\n1,2,3\r\n0\r\n\r\n"]
)
def test_chunks_that_are_none_end_the_request(hasty: Service, body: bytes) -> None:
    _problem(answer(hasty.port, POST + CHUNKED + b"\r\n" + body), 400, "malformed-request")


@pytest.mark.parametrize("size", [1, 8])
def test_chunks_are_not_so_small_that_others_wait(hasty: Service, size: int) -> None:
    chunk = b"%x\r\n%s\r\n" % (size, b"#" * size)
    refused = answer(hasty.port, POST + CHUNKED + b"\r\n" + chunk * 200_000)
    assert "larger chunks" in _problem(refused, 400, "malformed-request")["detail"]
    some = b"".join(b"1\r\n%c\r\n" % byte for byte in CSV) + b"0\r\n\r\n"
    assert statuses(answer(hasty.port, POST + CHUNKED + b"Connection: close\r\n\r\n" + some)) == [200]


def test_trailers_are_bounded_and_are_no_headers(hasty: Service) -> None:
    chunks = b"%x\r\n%s\r\n0\r\n" % (len(CSV), CSV)
    head = POST + CHUNKED + b"Connection: close\r\n\r\n"
    answered = answer(hasty.port, head + chunks + b"If-None-Match: *\r\nX-Request-Id: late\r\n\r\n")
    assert statuses(answered) == [200] and b"x-request-id: late" not in answered
    endless = answer(hasty.port, head + chunks + b"X-A: aaaaaaaaaaaaaaaaaaaaa\r\n" * 10_000)
    _problem(endless, 431, "head-too-large")


H2C = b"Connection: Upgrade, HTTP2-Settings\r\nUpgrade: h2c\r\nHTTP2-Settings: AAMAAABk\r\n"
"""As `curl --http2` asks, and Java's client with each request."""
UPGRADES = {"h2c": H2C, "websocket": b"Connection: keep-alive, Upgrade\r\nUpgrade: websocket\r\n"}
BODIES = {
    "a length": (b"Content-Length: %d\r\n" % len(CSV), CSV),
    "chunks": (CHUNKED, b"%x\r\n%s\r\n0\r\nUpgrade: h2c\r\n\r\n" % (len(CSV), CSV)),
}


@pytest.mark.parametrize(("framing", "body"), BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("upgrade", UPGRADES.values(), ids=UPGRADES)
def test_another_protocol_is_not_spoken_but_requests_are_answered(
    hasty: Service, upgrade: bytes, framing: bytes, body: bytes
) -> None:
    """With their bodies, in whatever pieces they come, and the connection goes on."""
    request = POST + upgrade + framing + b"\r\n" + body
    last = GET[:-2] + b"Connection: close, Upgrade\r\nUpgrade: h2c\r\n\r\n"
    answered = answer(hasty.port, request + GET[:-2] + upgrade + b"\r\n" + request + last)
    assert statuses(answered) == [200] * 4 and answered.count(b'"cylinder"') >= 2
    head = len(request) - len(body)
    for cut in (30, head - 1, head, head + 1, head + 1000):
        with connected(hasty.port, request[:cut]) as connection:
            time.sleep(0.05)
            connection.sendall(request[cut:])
            assert statuses(one_answer(connection)) == [200]
            connection.sendall(last)
            assert statuses(rest(connection)) == [200]


def test_a_wish_to_close_is_heard_beside_that_for_another_protocol(hasty: Service) -> None:
    request = GET[:-2] + b"Connection: close\r\n" + H2C + b"\r\n"
    answered = answer(hasty.port, request)
    assert statuses(answered) == [200] and b"connection: close" in answered


def test_the_limits_hold_for_who_asks_for_another_protocol(hasty: Service) -> None:
    begun = GET[:-2] + b"Connection: close\r\n" + H2C
    # Without a space, which the new head has.
    lines = b"a:b\r\n" * (100 - begun.count(b": "))
    assert statuses(answer(hasty.port, begun + lines + b"\r\n")) == [200]
    assert statuses(answer(hasty.port, begun + lines + b"a:b\r\n\r\n")) == [431]
    full = begun + lines.removesuffix(b"\r\n") + b"b" * (HEAD - len(begun + lines) - 2) + b"\r\n\r\n"
    assert len(full) == HEAD and statuses(answer(hasty.port, full)) == [200]
    assert statuses(answer(hasty.port, full.replace(b"bb", b"bbb", 1))) == [431]
    assert statuses(answer(hasty.port, (GET[:-2] + H2C + b"\r\n") * 1000)) == [200] * 33 + [400]


@pytest.mark.parametrize("headers", AMBIGUOUS.values(), ids=AMBIGUOUS)
def test_a_body_whose_end_is_not_certain_is_refused_with_a_wish_for_another_protocol(
    hasty: Service, headers: bytes
) -> None:
    for request in (POST + H2C + headers, POST + headers + H2C):
        answered = answer(hasty.port, request + b"\r\n" + SMUGGLED)
        _problem(answered, 400, "malformed-request")
        assert len(statuses(answered)) == 1


def test_who_wants_a_tunnel_is_refused_and_no_more_is_read(hasty: Service) -> None:
    """Also with a body, or the wish for another protocol: the parser takes CONNECT for one by itself."""
    for more in (b"", H2C, b"Content-Length: 5\r\n"):
        tunnel = b"CONNECT %s HTTP/1.1\r\nHost: localhost\r\n" + more + b"\r\n" + GET
        assert statuses(answer(hasty.port, tunnel % b"/fit")) == [405]
        assert statuses(answer(hasty.port, tunnel % b"example.com:443")) == [400]


# Requests that follow one another without waiting.


def test_requests_in_one_packet_are_answered_in_order(hasty: Service) -> None:
    version = GET.replace(b"/livez", b"/version")
    fit = POST + b"Content-Length: %d\r\n\r\n" % len(CSV) + CSV
    last = GET[:-2] + b"Connection: close\r\n\r\n"
    answered = answer(hasty.port, GET + version + fit + GET.replace(b"/livez", b"/nothing") + last)
    assert statuses(answered) == [200, 200, 200, 404, 200]
    assert answered.index(b'"numpy"') < answered.index(b'"primitive"') < answered.index(b"not-found")


def test_what_follows_a_request_and_is_none_is_refused_after_its_answer(hasty: Service) -> None:
    fit = POST + b"Content-Length: %d\r\n\r\n" % len(CSV) + CSV
    answered = answer(hasty.port, fit + b"1,2,3\n")
    assert statuses(answered) == [200, 400]
    _problem(answered, 400, "malformed-request")


def test_few_requests_wait_for_another_on_a_connection(hasty: Service) -> None:
    answered = answer(hasty.port, GET * 1000)
    assert statuses(answered) == [200] * 33 + [400]
    _problem(answered, 400, "malformed-request")


# Bodies.


def test_a_body_that_stops_is_answered_and_closed(hasty: Service) -> None:
    request = POST + b"Content-Length: 100000\r\nX-Request-Id: half\r\n\r\n" + b"1,2,3\n" * 10_000
    answered = answer(hasty.port, request)
    _problem(answered, 408, "body-timeout")

    def line() -> dict[str, Any]:
        every = map(json.loads, hasty.log.read_text().splitlines())
        return next((line for line in every if line.get("request_id") == "half"), {})

    wait_for(lambda: bool(line()))
    assert (line()["status"], line()["problem"], line()["path"]) == (408, "body-timeout", "/fit")
    assert not list(hasty.temporary_directory.iterdir())


@pytest.mark.parametrize(
    ("path", "framing"),
    [("/fit", b"Content-Length: 1000"), ("/fit/batch", b"Content-Length: 1000"), ("/fit", CHUNKED.strip())],
)
def test_a_body_that_trickles_is_answered_and_closed(hasty: Service, path: str, framing: bytes) -> None:
    head = POST.replace(b"/fit", path.encode()) + framing + b"\r\n\r\n"
    with connected(hasty.port, head) as connection:
        connection.settimeout(0.1)
        start, answered = time.monotonic(), b""
        while not answered:
            connection.sendall(b"1\r\n,\r\n" if framing in CHUNKED else b",")
            assert time.monotonic() - start < SOON
            try:
                answered = connection.recv(1 << 16)
            except TimeoutError:
                continue
        connection.settimeout(PATIENCE)
        _problem(answered + rest(connection), 408, "body-timeout")


def test_a_body_that_moves_on_has_all_the_time_that_there_is(hasty: Service) -> None:
    rows = CSV.splitlines(keepends=True)
    with connected(hasty.port, POST + b"Content-Length: %d\r\n\r\n" % len(CSV)) as connection:
        for start in range(0, len(rows), 60):
            connection.sendall(b"".join(rows[start : start + 60]))
            time.sleep(0.4)
        assert statuses(rest(connection)) == [200]


def test_a_client_that_waits_for_100_gets_it(service: Service) -> None:
    head = POST + b"Content-Length: %d\r\nConnection: close\r\nExpect: 100-continue\r\n\r\n" % len(CSV)
    with connected(service.port, head) as connection:
        assert connection.recv(100) == b"HTTP/1.1 100 Continue\r\n\r\n"
        connection.sendall(CSV)
        assert statuses(rest(connection)) == [200]


def test_a_client_that_is_refused_is_not_asked_for_its_body(guarded_service: Any) -> None:
    """Nor is its next request taken for the body, which it may leave out."""
    head = POST + b"Content-Length: 39\r\nExpect: 100-continue\r\n\r\n"
    with connected(guarded_service.port, head) as connection:
        first = connection.recv(1 << 16)
        connection.sendall(GET)
        assert b"connection: close" in first and statuses(first + rest(connection)) == [401]


@pytest.mark.parametrize("framing", [b"Content-Length: 100000000000", CHUNKED.strip()])
@pytest.mark.parametrize("name", ["guarded_service", "strict_service"])
def test_what_comes_after_a_refusal_is_read_for_a_moment_only(
    request: pytest.FixtureRequest, name: str, framing: bytes
) -> None:
    service = request.getfixturevalue(name)
    piece = b"10000\r\n" + b"1" * 2**16 + b"\r\n" if framing in CHUNKED else b"1,2,3\n" * 10_000
    with connected(service.port, POST + framing + b"\r\n\r\n") as connection:
        # What the buffers of both sides hold, what the service takes, and a mebibyte.
        assert sent_until_closed(connection, piece, SOON) < 64 * MIB
        answered = rest(connection)
    assert statuses(answered) == [401 if name == "guarded_service" else 413]


def test_a_refusal_of_a_short_body_leaves_the_connection_open(guarded_service: Any) -> None:
    with connected(guarded_service.port, POST + b"Content-Length: 600\r\n\r\n") as connection:
        first = one_answer(connection)
        assert statuses(first) == [401] and b"connection: close" not in first
        connection.sendall(b"1,2,3\n" * 100 + GET)
        assert statuses(one_answer(connection)) == [200]


# Answers.


def _many_answers(service: Service) -> socket.socket:
    """A connection that has asked for more than all buffers hold, and has read nothing yet."""
    return connected(
        service.port, GET.replace(b"/livez", b"/openapi.json") * 33 + b"\r\n", receive_buffer=4096
    )


def test_a_client_that_takes_no_answer_is_closed(hasty: Service) -> None:
    with _many_answers(hasty) as connection:
        wait_for(lambda: "a client does not take its answer" in hasty.log.read_text(), SOON)
        assert statuses(rest(connection)).count(200) < 33


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not tell what they have sent")
def test_a_client_that_asks_on_but_takes_nothing_is_closed(hasty: Service) -> None:
    """All that it has asked for is in the system's buffers, and each request would be a sign of life."""
    ask = GET.replace(b"/livez", b"/openapi.json")
    with connected(hasty.port, ask, receive_buffer=4096) as connection:
        assert sent_until_closed(connection, GET, SOON, pause=0.1) < 100 * len(GET)


def test_a_client_that_takes_its_answer_slowly_gets_it(hasty: Service) -> None:
    with _many_answers(hasty) as connection:
        received, start = b"", time.monotonic()
        while time.monotonic() - start < 2.0:
            received += connection.recv(1 << 16)
            time.sleep(0.02)
        received += rest(connection)
    assert statuses(received).count(200) == 33


# Many connections.


def test_beyond_the_limit_connections_without_a_request_give_way(patient: Service) -> None:
    with ExitStack() as stack:
        idle = [stack.enter_context(connected(patient.port, request)) for request in [b"", GET[:9]] * PLACES]
        with httpx.Client(base_url=f"http://127.0.0.1:{patient.port}") as client:
            for _ in range(3):
                assert client.get("/livez").status_code == 200
            assert rest(idle[0]) == b""
            # The newest is still there.
            idle[-1].sendall(GET[9:])
            assert statuses(one_answer(idle[-1])) == [200]
        assert patient.log.read_text().count("places are taken") == 1


def test_beyond_the_limit_connections_are_refused_and_later_served_again(hasty: Service) -> None:
    with ExitStack() as stack:
        half = POST + b"Content-Length: 100000\r\n\r\n"
        for _ in range(PLACES):
            stack.enter_context(connected(hasty.port, half))
        time.sleep(0.2)
        with connected(hasty.port) as connection:
            answered = rest(connection)
        _problem(answered, 503, "too-many-connections")
        assert b"Retry-After: 1" in answered
        # Each of these has its time, and then there are places again.
        wait_for(lambda: statuses(answer(hasty.port, GET[:-2] + b"Connection: close\r\n\r\n")) == [200], SOON)


@pytest.fixture
def followed(patient: Service) -> Iterator[str]:
    """The path of a job that does not end soon."""
    path = hand_in(patient, many(2000))
    yield path
    patient.client.delete(path)


def _following(service: Service, path: str, last_id: int = 0) -> tuple[socket.socket, bytes]:
    """A connection that gets the events of a job behind one of them, and what came until the first result."""
    asked = GET[:-2].replace(b"/livez", f"{path}/events".encode())
    connection = connected(service.port, asked + b"Last-Event-ID: %d\r\n\r\n" % last_id)
    received = b""
    while b"\nid: " not in received:
        piece = connection.recv(1 << 16)
        assert piece, f"closed after {received!r}"
        received += piece
    return connection, received


def test_beyond_the_limit_streams_of_events_give_way_and_go_on_elsewhere(
    patient: Service, followed: str
) -> None:
    """Also those on whose connections other requests wait, which would hold their places for as long."""
    with ExitStack() as stack:
        streams = [_following(patient, followed) for _ in range(PLACES)]
        for connection, _ in streams:
            stack.enter_context(connection)
        for connection, _ in streams[:-1]:
            connection.sendall(GET)
        last = GET[:-2] + b"Connection: close\r\n\r\n"
        # Each of these leaves a place for the next one.
        for _ in range(3):
            assert statuses(answer(patient.port, last)) == [200]
        # The oldest is closed before it has told all; the newest still tells.
        oldest, told = streams[0]
        told += rest(oldest)
        assert b"id: end" not in told
        told_now = b""
        while b"event: result" not in told_now:
            piece = streams[-1][0].recv(1 << 16)
            assert piece, "the newest stream was closed"
            told_now += piece
        # Whoever names the last event that came whole goes on behind it.
        last_id = int(told[: told.rindex(b"\n\n")].rpartition(b"\nid: ")[2].split()[0])
        resumed, goes_on = _following(patient, followed, last_id)
        stack.enter_context(resumed)
        assert b"event: result\nid: %d\n" % (last_id + 1) in goes_on
        assert b"id: %d\n" % last_id not in goes_on


def test_the_next_request_behind_a_stream_of_events_has_a_place(patient: Service) -> None:
    """A request whose answer is no stream is not cut off, although one was before on its connection."""
    path = hand_in(patient, many(5))
    ended(patient, path)
    stream = GET.replace(b"/livez", f"{path}/events".encode())
    half = POST + b"Content-Length: 100000\r\n\r\n"
    with ExitStack() as stack:
        first = stack.enter_context(connected(patient.port, stream + half))
        for _ in range(PLACES - 1):
            stack.enter_context(connected(patient.port, half))
        time.sleep(0.5)
        _problem(answer(patient.port, b""), 503, "too-many-connections")
        assert b"id: end" in first.recv(1 << 16)


@pytest.mark.skipif(not hasattr(resource, "prlimit"), reason="limits another process, as Linux can")
@needs_proc
def test_a_service_without_descriptors_waits_for_them(patient: Service) -> None:
    with ExitStack() as stack:
        n_open = len(list(Path(f"/proc/{patient.pid}/fd").iterdir()))
        limits = resource.prlimit(patient.pid, resource.RLIMIT_NOFILE)
        resource.prlimit(patient.pid, resource.RLIMIT_NOFILE, (n_open + 3, limits[1]))
        for _ in range(40):
            stack.enter_context(connected(patient.port))
        wait_for(lambda: "out of system resource" in patient.log.read_text(), SOON)
        before = ticks(patient.pid)
        time.sleep(2.0)
        assert ticks(patient.pid) - before < 50
        assert patient.log.read_text().count("out of system resource") == 1
        resource.prlimit(patient.pid, resource.RLIMIT_NOFILE, limits)
        with httpx.Client(base_url=f"http://127.0.0.1:{patient.port}", timeout=SOON) as client:
            assert client.get("/livez").status_code == 200


@pytest.mark.parametrize(("soft", "places"), [(1024, 341), (2, 1), (10**6, 1000)])
def test_the_places_follow_from_the_descriptors(
    monkeypatch: pytest.MonkeyPatch, soft: int, places: int
) -> None:
    monkeypatch.setattr(resource, "getrlimit", lambda _: (soft, resource.RLIM_INFINITY))
    assert Settings().max_connections == places


# The log, and the clock.


def test_the_log_does_not_repeat_itself(hasty: Service) -> None:
    line = "refused at the door: malformed-request"
    before = hasty.log.read_text().count(line)
    for _ in range(50):
        _problem(answer(hasty.port, b"NOT HTTP\r\n\r\n"), 400, "malformed-request")
    # The second is of another minute.
    assert hasty.log.read_text().count(line) <= before + 2
    metrics = hasty.client.get("/metrics").text
    (counted,) = (line for line in metrics.splitlines() if 'problems_total{type="malformed-request"}' in line)
    assert float(counted.split()[-1]) >= 50


def test_the_next_line_says_how_many_were_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    once, clock = Once(), iter((0.0, 1.0, 1.0, 59.0, 60.0, 61.0))
    monkeypatch.setattr("primfit.app.workers.logs.time.monotonic", lambda: next(clock))

    def told(message: str) -> Any:
        record = logging.makeLogRecord({"msg": message})
        return getattr(record, "facts", {}) if once.filter(record) else None

    messages = ("full", "full", "other", "full", "full", "full")
    assert [told(message) for message in messages] == [{}, None, {}, None, {"left_out": 2}, None]


def test_a_pace_is_averaged_over_a_stretch_and_all_has_an_end() -> None:
    pace = Pace(stretch=2.0, rate=10.0, limit=5.0)
    pace.moved(20)
    assert pace.complaint(1.0) is None and pace.complaint(1.0) is None
    assert pace.complaint(1.0) is None
    pace.moved(19)
    assert pace.complaint(1.0) == "19 bytes in 2 s; 10 a second are needed"
    pace.restart()
    for _ in range(5):
        pace.moved(100)
        assert pace.complaint(1.0) is None
    assert pace.complaint(1.0) == "incomplete after 5 s"


def test_a_service_that_stops_does_not_wait_for_idle_connections(tmp_path: Path) -> None:
    with running(tmp_path / "bodies", workers=1, stop_patience=60) as service, ExitStack() as stack:
        for request in (b"", GET[:9], GET):
            stack.enter_context(connected(service.port, request))
        start = time.monotonic()
        service.process.terminate()
        assert service.process.wait(PATIENCE) == 0
        assert time.monotonic() - start < 30


def test_keys_are_asked_for_after_all_this(guarded_service: Any) -> None:
    key = b"X-API-Key: %s\r\nConnection: close\r\n\r\n" % ALICE.encode()
    version = GET.replace(b"/livez", b"/version")[:-2]
    assert statuses(answer(guarded_service.port, version + key)) == [200]
    assert statuses(answer(guarded_service.port, version + b"X-A: " + b"a" * HEAD + b"\r\n" + key)) == [431]
