"""What the page shows if something is refused, or nobody answers: the words of the service, and a way on."""

import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import httpx
import numpy as np
import pytest

from tests.app.browser import ENTER, Browser, needs_browser
from tests.app.processes import needs_proc
from tests.app.service.scans import csv, many
from tests.app.serving import ALICE, Background, Service, running, stopped, wait_for, workers
from tests.app.viewing import (
    FITTING,
    REFUSED,
    answered,
    drop,
    drop_file,
    offline,
    pressed,
    text,
    visit,
)
from tests.paths import ROOT

pytestmark = [pytest.mark.browser, needs_browser]
PIPE = ROOT / "samples" / "pipe.ply"
KEY = "input[type=password]"
SELECT = """
const labels = [...document.querySelectorAll("form label")];
const field = labels.find((each) => each.innerText.startsWith(arguments[0])).querySelector("input");
field.focus();
field.select();
"""
NOT_SAVED = "document.querySelector('#take ~ .warning')?.innerText"
FILES = {
    "one point": b"x,y,z\n1,2,3\n",
    "no numbers": b"\x00\x01\x02 no cloud at all \xff" * 20,
    "empty": b"",
    "on a line": b"".join(b"%d,0,0\n" % i for i in range(50)),
    "not finite": b"x,y,z\n1,2,nan\n" * 20,
}


def refusal(page: Browser) -> str:
    """What is told of a problem."""
    page.wait_for(REFUSED)
    return str(page.run("return document.querySelector('.problem').innerText"))


def tells(page: Browser, problem: dict[str, Any]) -> None:
    """The page shows title, detail and errors of a problem."""
    told = refusal(page)
    for words in (problem["title"], problem["detail"], *(each["message"] for each in problem["errors"])):
        assert words.lower() in told.lower()


def still_works(page: Browser) -> None:
    drop_file(page, PIPE)
    assert answered(page) == "A cylinder"
    assert not page.run(f"return {REFUSED}")


@pytest.mark.parametrize("content", FILES.values(), ids=FILES)
def test_a_file_is_refused(viewer: Browser, service: Service, content: bytes) -> None:
    drop(viewer, content, "points.csv")
    reply = service.client.post("/fit", files={"file": ("points.csv", content)})
    assert reply.status_code == 422
    tells(viewer, reply.json())
    still_works(viewer)


@pytest.mark.parametrize(
    ("field", "entry", "options"),
    [
        ("Tolerance", "0", '{"tolerance": 0}'),
        ("Known radius", "-3", '{"constraints": {"radius": {"value": -3}}}'),
        ("Known axis", "0 0 0", '{"constraints": {"axis": {"direction": [0, 0, 0], "max_angle": 0}}}'),
    ],
)
def test_an_option_is_refused(
    viewer: Browser, service: Service, field: str, entry: str, options: str
) -> None:
    drop_file(viewer, PIPE)
    answered(viewer)
    enter(viewer, field, entry)
    files = {"file": (PIPE.name, PIPE.read_bytes()), "options": (None, options)}
    tells(viewer, service.client.post("/fit", files=files).json())
    enter(viewer, field, "")
    assert answered(viewer) == "A cylinder"


def enter(page: Browser, field: str, entry: str) -> None:
    """Fill a field with this instead of what it holds, and press Enter in it."""
    page.run(SELECT, field)
    page.press(*(entry or "\ue017"), ENTER)


def test_what_is_no_number_is_not_sent(viewer: Browser) -> None:
    drop_file(viewer, PIPE)
    answered(viewer)
    viewer.network()
    enter(viewer, "Tolerance", "two")
    assert viewer.run("return document.querySelector('form').matches(':invalid')")
    assert viewer.run("return document.querySelector('input:invalid').validationMessage") == (
        "A number is needed, such as 0.5."
    )
    assert viewer.hosts() == set()
    enter(viewer, "Tolerance", "2")
    viewer.wait_for("document.querySelector('.band') !== null")


def test_a_wrong_key_is_told_and_the_right_one_works(page: Browser, guarded_service: Service) -> None:
    visit(page, guarded_service.port)
    tells(page, guarded_service.client.get("/capabilities").json())
    page.type(KEY, f"a-wrong-key-{ENTER}")
    wrong = guarded_service.client.get("/capabilities", headers={"X-API-Key": "a-wrong-key-"}).json()
    page.wait_for("document.querySelector('.problem')?.innerText.includes('Key') ?? false")
    tells(page, wrong)
    page.type(KEY, ALICE + ENTER)
    page.wait_for(f"!({REFUSED})")
    still_works(page)


def test_a_body_that_is_too_large(page: Browser, strict_service: Service) -> None:
    visit(page, strict_service.port)
    content = many(10, 4000)
    drop(page, content, "large.csv")
    reply = strict_service.client.post("/fit/batch?labels=auto", files={"file": ("large.csv", content)})
    assert reply.status_code == 413
    tells(page, reply.json())
    still_works(page)


def test_too_many_points(page: Browser, strict_service: Service) -> None:
    visit(page, strict_service.port)
    content = b"1,2,3\n" * 30_000
    drop(page, content, "many.csv")
    reply = strict_service.client.post("/fit", files={"file": ("many.csv", content)})
    tells(page, reply.json())
    still_works(page)


@needs_proc
def test_a_full_queue(page: Browser, strict_service: Service) -> None:
    visit(page, strict_service.port)
    with stopped(strict_service):
        held = [Background(strict_service, PIPE.read_bytes()) for _ in range(2)]
        for request in held:
            request.start()
        wait_for(lambda: 'primfit_queue_length{lane="small"} 1' in strict_service.client.get("/metrics").text)
        drop_file(page, PIPE)
        assert refusal(page).startswith("Too many requests are waiting")
    for request in held:
        request.join()
    pressed(page, "Try again")
    assert answered(page) == "A cylinder"


def test_too_many_requests(page: Browser, tmp_path: Any) -> None:
    """What the page could not learn then it learns later; and the same service goes away in the end."""
    with running(tmp_path / "bodies", workers=1, rate_limit="40/20seconds") as service:
        visit(page, service.port)
        while (refused := service.client.get("/version")).status_code != 429:
            pass
        drop_file(page, PIPE)
        told = refusal(page)
        assert refused.json()["title"] in told
        while page.run(f"return {REFUSED}"):
            time.sleep(4)  # a fifth of the window
            pressed(page, "Try again")
            page.wait_for("document.querySelector('.busy') === null")
        assert answered(page) == "A cylinder"
        os.kill(service.pid, signal.SIGKILL)
        service.process.wait()
        pressed(page, "Fit")
        assert refusal(page).startswith("The service does not answer")
        assert "A cylinder" in text(page)


@needs_proc
def test_a_service_that_stops_says_so(page: Browser, tmp_path: Any) -> None:
    """What was asked is answered with 503; what is asked afterwards by nobody."""
    with running(tmp_path / "bodies", workers=1, stop_patience=1) as service:
        visit(page, service.port)
        wait_for(lambda: len(workers(service.pid)) == 1)
        with stopped(service):
            drop_file(page, PIPE)
            page.wait_for(FITTING)
            wait_for(lambda: "primfit_workers_busy 1" in service.client.get("/metrics").text)
            os.kill(service.pid, signal.SIGTERM)
            assert refusal(page).startswith("The service stopped")
        service.process.wait()
        pressed(page, "Try again")
        page.wait_for("document.querySelector('.problem h2')?.innerText === 'The service does not answer'")


def test_the_network_comes_back(viewer: Browser) -> None:
    drop_file(viewer, PIPE)
    answered(viewer)
    offline(viewer, True)
    pressed(viewer, "csv")
    viewer.wait_for(f"{NOT_SAVED} === 'The service does not answer.'")
    pressed(viewer, "Fit")
    assert refusal(viewer).startswith("The service does not answer")
    pressed(viewer, "Try again")
    viewer.wait_for("document.querySelector('.problem button') !== null")
    offline(viewer, False)
    pressed(viewer, "Try again")
    viewer.wait_for(f"!({REFUSED})")
    assert answered(viewer) == "A cylinder"


class Gateway(BaseHTTPRequestHandler):
    """A proxy that has lost the service for all that takes long."""

    port = 0

    def do_GET(self) -> None:
        reply = httpx.get(f"http://127.0.0.1:{self.port}{self.path}", headers={"Accept-Encoding": "identity"})
        self._send(reply.status_code, reply.headers["content-type"], reply.content)

    def do_POST(self) -> None:
        self.rfile.read(int(self.headers["Content-Length"]))
        self._send(502, "text/html", b"<h1>Bad Gateway</h1>")

    def _send(self, status: int, kind: str, content: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_: Any) -> None:
        pass


@contextmanager
def gateway(service: Service) -> Iterator[int]:
    handler = type("Handler", (Gateway,), {"port": service.port})
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever).start()
        try:
            yield server.server_port
        finally:
            server.shutdown()


def test_a_proxy_that_has_lost_the_service(page: Browser, service: Service) -> None:
    with gateway(service) as port:
        visit(page, port)
        drop_file(page, PIPE)
        assert "The server answered with status 502." in refusal(page)
        assert page.run("return document.querySelector('.problem button').innerText") == "Try again"


def test_a_refused_segment_says_why(viewer: Browser) -> None:
    points = np.array([*([i % 7, i % 5, 0.0] for i in range(60)), [1.0, 2.0, 3.0]])
    content = csv(points, [1] * 60 + [2])
    drop(viewer, content, "two.csv")
    answered(viewer)
    viewer.run("document.querySelectorAll('.segments button')[1].click()")
    viewer.wait_for("document.querySelector('.segments ~ .warning, .scroll ~ .warning') !== null")
    assert "1 point" in text(viewer)


@needs_proc
def test_a_scan_is_canceled_and_what_was_found_stays(viewer: Browser, service: Service) -> None:
    drop(viewer, many(300), "long.csv")
    viewer.wait_for("document.querySelectorAll('.segments li').length >= 3")
    assert viewer.run(f"return {FITTING}")
    pressed(viewer, "Cancel")
    viewer.wait_for("document.querySelector('.status').innerText === 'Canceled. What was found stays.'")
    found = viewer.run("return document.querySelectorAll('.segments li').length")
    assert 3 <= found < 300
    wait_for(lambda: "primfit_workers_busy 0" in service.client.get("/metrics").text, 10)
    assert len(workers(service.pid)) == 2
    viewer.run("document.querySelector('.segments button').click()")
    viewer.wait_for("document.querySelector('#verdict')?.innerText === 'A cylinder'")
    assert viewer.run("return document.querySelectorAll('.segments li').length") == found
