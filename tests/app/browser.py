"""Pages in Chromium, through the WebDriver protocol."""

import base64
import json
import shutil
import socket
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest

PATIENCE = 60.0
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"
TAB, ENTER, ESCAPE, SPACE, SHIFT = "\ue004", "\ue007", "\ue00c", " ", "\ue008"
LEFT, UP, RIGHT, DOWN, HOME = "\ue012", "\ue013", "\ue014", "\ue015", "\ue011"
"""Keys, by the WebDriver protocol."""
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1100,1600",
)
WITHOUT_GRAPHICS = ("--disable-gpu",)
IN_SOFTWARE = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
"""WebGL without a graphics card."""

needs_browser = pytest.mark.skipif(
    not (shutil.which("chromium") and shutil.which("chromedriver")),
    reason="needs chromium and chromedriver (Debian and Ubuntu: apt install chromium chromium-driver)",
)


class Browser:
    """A page in Chromium, through the WebDriver protocol."""

    def __init__(self, driver: httpx.Client, profile: Path, flags: Sequence[str]) -> None:
        self._driver = driver
        options = {
            "args": [*FLAGS, *flags, f"--user-data-dir={profile}"],
            "perfLoggingPrefs": {"enableNetwork": True},
        }
        wanted = {
            "goog:chromeOptions": options,
            "goog:loggingPrefs": {"performance": "ALL", "browser": "ALL"},
        }
        made = self._call("/session", {"capabilities": {"alwaysMatch": wanted}})
        self._session = f"/session/{made['sessionId']}"

    def _call(self, path: str, body: Any) -> Any:
        reply = self._driver.post(path, json=body)
        assert reply.status_code == 200, reply.text
        return reply.json()["value"]

    def open(self, url: str) -> None:
        self._call(f"{self._session}/url", {"url": url})

    def run(self, script: str, *arguments: Any) -> Any:
        """The value that a script returns, or the promise that it returns holds."""
        return self._call(f"{self._session}/execute/sync", {"script": script, "args": arguments})

    def element(self, selector: str) -> str:
        found = self._call(f"{self._session}/element", {"using": "css selector", "value": selector})
        return f"{self._session}/element/{found[ELEMENT]}"

    def click(self, selector: str) -> None:
        self._call(f"{self.element(selector)}/click", {})

    def type(self, selector: str, text: str) -> None:
        self._call(f"{self.element(selector)}/value", {"text": text})

    def press(self, *keys: str, shift: bool = False) -> None:
        """Press keys, one after the other, on what has the focus."""
        strokes = [{"type": way, "value": key} for key in keys for way in ("keyDown", "keyUp")]
        if shift:
            held = {"value": SHIFT}
            strokes = [{"type": "keyDown", **held}, *strokes, {"type": "keyUp", **held}]
        self._act({"type": "key", "id": "keys", "actions": strokes})

    def drag(self, *places: tuple[float, float]) -> None:
        """Move the mouse along places of the window [CSS pixels] with its button down; one is a click."""
        (x, y), *others = places
        steps: list[dict[str, Any]] = [{"type": "pointerMove", "x": round(x), "y": round(y), "duration": 0}]
        steps += [{"type": "pointerDown", "button": 0}]
        steps += [{"type": "pointerMove", "x": round(u), "y": round(v), "duration": 20} for u, v in others]
        steps += [{"type": "pointerUp", "button": 0}]
        self._act(
            {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": steps}
        )

    def _act(self, source: Mapping[str, Any]) -> None:
        self._call(f"{self._session}/actions", {"actions": [source]})

    def touch(self, *places: tuple[float, float]) -> None:
        """Move a finger along places of the window [CSS pixels]."""
        for kind, place in zip(["touchStart", *["touchMove"] * (len(places) - 1)], places, strict=True):
            self.command(
                "Input.dispatchTouchEvent", type=kind, touchPoints=[dict(zip("xy", place, strict=True))]
            )
        self.command("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def resize(self, width: int, height: int = 900) -> None:
        """Show the page on a screen of this size."""
        mobile = width < 500
        self.command(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=mobile,
        )

    def prefer(self, **features: str) -> None:
        """What the user has asked the system for, such as `color_scheme="dark"`; nothing for the usual."""
        told = [
            {"name": f"prefers-{name.replace('_', '-')}", "value": value} for name, value in features.items()
        ]
        self.command("Emulation.setEmulatedMedia", features=told)

    def command(self, name: str, **params: Any) -> Any:
        """A command of Chromium's own protocol."""
        return self._call(f"{self._session}/goog/cdp/execute", {"cmd": name, "params": params})

    def network(self) -> list[dict[str, Any]]:
        """What was sent and received since this was asked before."""
        events = self._call(f"{self._session}/se/log", {"type": "performance"})
        messages = [json.loads(event["message"])["message"] for event in events]
        return [message for message in messages if message["method"].startswith("Network.")]

    def hosts(self) -> set[str]:
        """Every host that something was asked of; the browser's own pages have none."""
        sent = [m["params"] for m in self.network() if m["method"] == "Network.requestWillBeSent"]
        urls = [params["request"]["url"] for params in sent]
        return {httpx.URL(url).host for url in urls if url.startswith(("http", "ws"))}

    def complaints(self) -> list[str]:
        """Errors and warnings in the console, such as of what the page's policy forbids."""
        return [entry["message"] for entry in self._call(f"{self._session}/se/log", {"type": "browser"})]

    def picture(self) -> bytes:
        """What is seen, as PNG."""
        reply = self._driver.get(f"{self._session}/screenshot")
        return base64.b64decode(reply.json()["value"])

    def wait_for(self, condition: str) -> None:
        """Wait until an expression is true on the page; where it never is, tell what is seen instead."""
        try:
            wait_for(lambda: bool(self.run(f"return {condition}")))
        except AssertionError as late:
            late.add_note(f"{condition}\nThe page shows: {self.run('return document.body.innerText')!r}")
            late.add_note(f"The console says: {self.complaints()}")
            raise

    def close(self) -> None:
        self._driver.delete(self._session)


@contextmanager
def browser(profile: Path, flags: Sequence[str]) -> Iterator[Browser]:
    """A browser that ends with the block."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    process = subprocess.Popen(["chromedriver", f"--port={port}"], stdout=subprocess.DEVNULL)
    try:
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE, trust_env=False) as driver:
            wait_for(lambda: _answers(driver))
            started = Browser(driver, profile, flags)
            yield started
            started.close()
    finally:
        process.terminate()
        process.wait()


def wait_for(condition: Callable[[], bool]) -> None:
    """Poll until the condition holds."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline, "it did not happen in time"
        time.sleep(0.05)


def _answers(driver: httpx.Client) -> bool:
    try:
        return bool(driver.get("/status").json()["value"]["ready"])
    except httpx.TransportError:
        return False
