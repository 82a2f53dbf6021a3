"""The page at / in a browser: how tests and tools open it, give it files, and read it."""

import base64
import itertools
from pathlib import Path

from tests.app.browser import Browser

DROP = """
const bytes = Uint8Array.from(atob(arguments[0]), (letter) => letter.charCodeAt(0));
const transfer = new DataTransfer();
transfer.items.add(new File([bytes], arguments[1]));
document.body.dispatchEvent(
  new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
"""
PRESS = """
const buttons = [...document.querySelectorAll("button")];
buttons.find((each) => each.textContent.startsWith(arguments[0])).click();
"""
EXAMPLE = """
const list = document.querySelector("header select");
list.value = arguments[0];
list.dispatchEvent(new Event("change", { bubbles: true }));
"""
VERDICT = "document.querySelector('#verdict')?.textContent"
REFUSED = "document.querySelector('.problem') !== null"
FITTING = "document.querySelector('.busy button') !== null"
_visits = itertools.count()


def visit(page: Browser, port: int) -> None:
    """Open the page anew, without options or a key, and wait until it knows what the service can do."""
    page.open(_address(port))
    if page.run("const known = sessionStorage.length > 0; sessionStorage.clear(); return known"):
        page.open(_address(port))  # a test before this one gave a key
    page.wait_for("document.querySelector('header select') !== null")


def _address(port: int) -> str:
    return f"http://127.0.0.1:{port}/?{next(_visits)}"


def drop(page: Browser, content: bytes, name: str) -> None:
    page.run(DROP, base64.b64encode(content).decode(), name)


def drop_file(page: Browser, path: Path) -> None:
    drop(page, path.read_bytes(), path.name)


def answered(page: Browser) -> str:
    """The heading of the answer, once it is there; of a scan, once all segments are."""
    page.wait_for("!document.querySelector('.status') && document.querySelector('#verdict, .segments li')")
    return str(page.run(f"return {VERDICT}"))


def text(page: Browser) -> str:
    return str(page.run("return document.querySelector('aside').innerText"))


def pressed(page: Browser, words: str) -> None:
    """Press the button that begins with these words, by a script."""
    page.run(PRESS, words)


def place(page: Browser, selector: str) -> tuple[float, float, float, float]:
    """Left, top, width and height of an element in the window, which is scrolled to it."""
    x, y, width, height = page.run(
        "const found = document.querySelector(arguments[0]); found.scrollIntoView({ block: 'center' });"
        "const { x, y, width, height } = found.getBoundingClientRect(); return [x, y, width, height]",
        selector,
    )
    return x, y, width, height


def spot(page: Browser, selector: str, across: float, down: float) -> tuple[float, float]:
    """A place in an element, by shares of its width and height."""
    x, y, width, height = place(page, selector)
    return x + across * width, y + down * height


def offline(page: Browser, on: bool) -> None:
    """Take the network away, or give it back."""
    page.command("Network.enable")
    rates = {"latency": 0, "downloadThroughput": -1, "uploadThroughput": -1}
    page.command("Network.emulateNetworkConditions", offline=on, **rates)
