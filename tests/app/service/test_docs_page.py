"""The page at /docs in a real browser: it shows every operation, fits clouds, and asks the service alone."""

import json
import re
import shutil
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.paths import EXAMPLES

PATIENCE = 60.0
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1100,1600",
)

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(
        not (shutil.which("chromium") and shutil.which("chromedriver")),
        reason="needs chromium and chromedriver (Debian and Ubuntu: apt install chromium chromium-driver)",
    ),
]


class Browser:
    """A page in Chromium, through the WebDriver protocol."""

    def __init__(self, driver: httpx.Client, profile: Path) -> None:
        self._driver = driver
        options = {
            "args": [*FLAGS, f"--user-data-dir={profile}"],
            "perfLoggingPrefs": {"enableNetwork": True},
        }
        wanted = {"goog:chromeOptions": options, "goog:loggingPrefs": {"performance": "ALL"}}
        made = self._call("/session", {"capabilities": {"alwaysMatch": wanted}})
        self._session = f"/session/{made['sessionId']}"

    def _call(self, path: str, body: Any) -> Any:
        reply = self._driver.post(path, json=body)
        assert reply.status_code == 200, reply.text
        return reply.json()["value"]

    def open(self, url: str) -> None:
        self._call(f"{self._session}/url", {"url": url})

    def run(self, script: str) -> Any:
        """The value that a script returns."""
        return self._call(f"{self._session}/execute/sync", {"script": script, "args": []})

    def element(self, selector: str) -> str:
        found = self._call(f"{self._session}/element", {"using": "css selector", "value": selector})
        return f"{self._session}/element/{found[ELEMENT]}"

    def click(self, selector: str) -> None:
        self._call(f"{self.element(selector)}/click", {})

    def type(self, selector: str, text: str) -> None:
        self._call(f"{self.element(selector)}/value", {"text": text})

    def hosts(self) -> set[str]:
        """Every host that something was asked of; the browser's own pages have none."""
        events = self._call(f"{self._session}/se/log", {"type": "performance"})
        messages = [json.loads(event["message"])["message"] for event in events]
        urls = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
        return {httpx.URL(url).host for url in urls if url.startswith(("http", "ws"))}

    def close(self) -> None:
        self._driver.delete(self._session)


@pytest.fixture(scope="module")
def page(service: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """The documentation, drawn."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    process = subprocess.Popen(["chromedriver", f"--port={port}"], stdout=subprocess.DEVNULL)
    try:
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE, trust_env=False) as driver:
            _wait_for(lambda: _answers(driver))
            browser = Browser(driver, tmp_path_factory.mktemp("profile"))
            browser.open(f"http://127.0.0.1:{service.port}/docs")
            _wait_for(lambda: browser.run("return document.getElementById('schemas') !== null"))
            yield browser
            browser.close()
    finally:
        process.terminate()
        process.wait()


def _wait_for(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline, "it did not happen in time"
        time.sleep(0.05)


def _answers(driver: httpx.Client) -> bool:
    try:
        return bool(driver.get("/status").json()["value"]["ready"])
    except httpx.TransportError:
        return False


def test_it_shows_every_operation(page: Browser, service: Any) -> None:
    document = service.client.get("/openapi.json").json()
    headings = page.run("return [...document.querySelectorAll('main h2')].map(h => [h.id, h.textContent])")
    expected = {
        operation["operationId"]: f"{method.upper()} {path} {operation['summary']}"
        for path, methods in document["paths"].items()
        for method, operation in methods.items()
    }
    assert dict(headings) == expected | {"schemas": "Schemas"}
    links = page.run("return [...document.querySelectorAll('nav a')].map(a => a.hash.slice(1))")
    assert sorted(links) == sorted([*expected, "schemas"])


def _found(page: Browser) -> str:
    answers = "return [...document.querySelectorAll('.found')].map(found => found.textContent)"
    _wait_for(lambda: page.run(answers) != [])
    return str(page.run(answers)[0])


def test_it_fits_the_example(page: Browser) -> None:
    page.click("#fit + p + .trial .send")
    assert re.search(r"cylinder, fitted.*radius.*12\.(49|50)", _found(page))


def test_it_fits_a_file_with_options(page: Browser) -> None:
    page.type("#fit + p + .trial input[type=file]", str(EXAMPLES / "cylinder.csv"))
    page.type("#fit + p + .trial input[type=text]", '{"kinds": ["sphere"]}')
    page.run("document.querySelectorAll('.found').forEach(found => found.remove())")
    page.click("#fit + p + .trial .send")
    assert "sphere, no_fit" in _found(page)


def test_it_asks_nobody_but_the_service(page: Browser) -> None:
    page.click("#livez + p + .trial .send")
    _wait_for(lambda: "alive" in page.run("return document.querySelector('#livez + p + .trial').textContent"))
    assert page.hosts() == {"127.0.0.1"}
