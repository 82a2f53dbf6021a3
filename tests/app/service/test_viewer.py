"""The page at / in a real browser: it shows every state there is, and asks the service alone."""

import gzip
import io
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
from PIL import Image

from primfit.benchmark.service import csv, npy
from tests.app.browser import Browser, needs_browser
from tests.app.serving import ALICE
from tests.app.viewing import VERDICT, answered, drop, drop_file, pressed, text, visit
from tests.paths import ROOT

pytestmark = [pytest.mark.browser, needs_browser]
MOST_BYTES = 200_000
"""All scripts and styles together, packed as they are sent."""
GROUND = [0x23, 0x28, 0x2E]
CHOOSE = """
const [list, value] = [document.querySelector(arguments[0]), arguments[1]];
list.value = value;
list.dispatchEvent(new Event("change", { bubbles: true }));
"""
LASSO = """
const canvas = document.querySelector(".picture canvas");
const { left, top, width, height } = canvas.getBoundingClientRect();
const send = (name, x, y) => canvas.dispatchEvent(new PointerEvent(name, {
  pointerId: 1, clientX: left + x * width, clientY: top + y * height, bubbles: true, isPrimary: true }));
canvas.setPointerCapture = () => {};
const corners = arguments[0];
send("pointerdown", ...corners[0]);
corners.slice(1).forEach((corner) => send("pointermove", ...corner));
send("pointerup", ...corners.at(-1));
"""


def _lit(page: Browser) -> int:
    """How many pixels of the picture are not its ground."""
    frame = "const r = document.querySelector('.picture').getBoundingClientRect();"
    place = page.run(f"{frame} return [r.x, r.y, r.right, r.bottom]")
    image = Image.open(io.BytesIO(page.picture())).convert("RGB").crop([int(each) for each in place])
    away = np.abs(np.asarray(image).astype(int) - GROUND).max(axis=2)
    return int((away > 40).sum())


@pytest.mark.parametrize(
    ("name", "kind"),
    [("pipe", "cylinder"), ("ball", "sphere"), ("plate", "plane"), ("nozzle", "cone"), ("elbow", "torus")],
)
def test_an_example_of_each_kind(viewer: Browser, name: str, kind: str) -> None:
    viewer.run(CHOOSE, "header select", name)
    assert answered(viewer) == f"A {kind}"
    assert _lit(viewer) > 3000
    told = text(viewer)
    assert "What was tried" in told and "left out as outliers" in told and "accepted" in told
    assert viewer.run("return document.querySelectorAll('.histogram rect').length") == 41
    shown = f"{kind} rolled out"
    assert shown in viewer.run("return document.querySelector('.map').getAttribute('aria-label')")


def test_no_fit_says_so_and_its_steps_can_be_looked_at(viewer: Browser) -> None:
    drop_file(viewer, ROOT / "samples" / "corner.xyz")
    assert answered(viewer).startswith("No fit; closest is a ")
    n_steps = viewer.run("return document.querySelectorAll('.attempts button').length")
    assert n_steps == 5
    for step in range(n_steps):
        viewer.run(f"document.querySelectorAll('.attempts button')[{step}].click()")
        pressed = (
            f"document.querySelectorAll('.attempts button')[{step}].getAttribute('aria-pressed') === 'true'"
        )
        viewer.wait_for(pressed)
    assert _lit(viewer) > 3000


def test_an_ambiguous_answer_names_the_others(viewer: Browser) -> None:
    drop_file(viewer, ROOT / "samples" / "short-arc.csv")
    assert answered(viewer) == "A cylinder, or another"
    assert "Also possible: a plane." in text(viewer)
    assert viewer.run("return document.querySelector('#verdict').className") == "ambiguous"


def test_options_are_asked_for_and_stand_in_the_link(viewer: Browser, service: Any) -> None:
    viewer.run(CHOOSE, "header select", "pipe")
    answered(viewer)
    for kind in ("plane", "sphere", "cylinder", "torus"):
        place = ["plane", "sphere", "cylinder", "cone", "torus"].index(kind)
        viewer.run(f"document.querySelectorAll('fieldset input')[{place}].click()")
    pressed(viewer, "Fit")
    viewer.wait_for(f"{VERDICT} && !document.querySelector('.status') && !{VERDICT}.includes('cylinder')")
    assert "cone" in viewer.run(f"return {VERDICT}")
    link = viewer.run("return location.hash")
    assert "cone" in link and "plane" not in link


def test_a_scan_is_fitted_segment_by_segment(viewer: Browser) -> None:
    drop_file(viewer, ROOT / "samples" / "plant.csv")
    viewer.wait_for(
        "document.querySelectorAll('.segments li').length === 4 && !document.querySelector('.status')"
    )
    assert "1 plane, 1 cylinder, 1 sphere, 1 cone" in text(viewer)
    viewer.run("document.querySelectorAll('.segments button')[2].click()")
    viewer.wait_for(f"{VERDICT} === 'A sphere'")
    pressed(viewer, "Open this segment alone")
    viewer.wait_for("!document.querySelector('.segments') && !document.querySelector('.status')")
    assert answered(viewer) == "A sphere"
    assert "900" in text(viewer)


def test_a_lasso_selects_what_is_fitted(viewer: Browser) -> None:
    """The right half of a pipe is a pipe of half the points, about."""
    viewer.run(CHOOSE, "header select", "pipe")
    answered(viewer)
    pressed(viewer, "Lasso")
    viewer.run(LASSO, [[0.5, 0.01], [0.99, 0.01], [0.99, 0.99], [0.5, 0.99]])
    viewer.wait_for(
        "[...document.querySelectorAll('button')].some((b) => b.textContent === 'Fit the selection')"
    )
    pressed(viewer, "Fit the selection")
    viewer.wait_for("document.querySelector('.name').textContent === 'pipe-selection.npy'")
    assert answered(viewer) == "A cylinder"
    count = "document.querySelectorAll('caption + tbody')[1].rows[0].cells[1].textContent"
    n_points = int(viewer.run(f"return {count}").replace(",", ""))
    assert 300 < n_points < 1200


def test_a_key_is_asked_for(page: Browser, guarded_service: Any) -> None:
    visit(page, guarded_service.port)
    page.wait_for("document.querySelector('input[type=password]') !== null")
    page.type("input[type=password]", ALICE)
    pressed(page, "Use it")
    page.wait_for("document.querySelector('.problem') === null")
    page.run(CHOOSE, "header select", "ball")
    assert answered(page) == "A sphere"
    page.complaints()


def test_points_are_pasted(viewer: Browser) -> None:
    rows = (ROOT / "samples" / "tank-end.xyz").read_text()
    viewer.run(
        "const data = new DataTransfer(); data.setData('text/plain', arguments[0]);"
        "dispatchEvent(new ClipboardEvent('paste', { clipboardData: data }))",
        rows,
    )
    assert answered(viewer) == "A sphere"


def test_a_file_that_only_the_service_reads_is_shown(viewer: Browser) -> None:
    packed = gzip.compress((ROOT / "samples" / "pipe.ply").read_bytes())
    drop(viewer, packed, "pipe.ply.gz")
    assert answered(viewer) == "A cylinder"
    assert _lit(viewer) > 3000


@pytest.mark.parametrize("write", [npy, csv])
def test_points_are_shown_before_they_are_fitted(viewer: Browser, write: Callable[[Any], bytes]) -> None:
    """While the service is not there, what the page reads itself is seen."""
    viewer.run("window.fetch = () => new Promise(() => undefined)")
    drop(viewer, write(np.random.default_rng(0).normal(0, 1, (3000, 3))), "cloud")
    viewer.wait_for("performance.getEntriesByName('points').length > 0")
    assert _lit(viewer) > 3000


def test_it_fits_on_a_phone(viewer: Browser) -> None:
    viewer.resize(360)
    viewer.run(CHOOSE, "header select", "elbow")
    answered(viewer)
    assert viewer.run("return document.documentElement.scrollWidth") == 360
    viewer.resize(1200)


def test_all_that_is_sent_is_small(page: Browser, service: Any) -> None:
    page.network()
    page.command("Network.clearBrowserCache")
    visit(page, service.port)
    page.run(CHOOSE, "header select", "pipe")
    answered(page)
    sent: dict[str, float] = {}
    urls = {}
    for message in page.network():
        params = message["params"]
        if message["method"] == "Network.requestWillBeSent":
            urls[params["requestId"]] = params["request"]["url"]
        if message["method"] == "Network.loadingFinished" and params["requestId"] in urls:
            sent[urls[params["requestId"]]] = params["encodedDataLength"]
    parts = {httpx.URL(url).path: size for url, size in sent.items() if "/viewer/" in url}
    assert set(parts) >= {"/viewer/viewer.js", "/viewer/viewer.css"}
    built = ROOT / "app" / "viewer" / "built"
    packed = sum(
        len(gzip.compress((built / name).read_bytes(), 9))
        for name in ("viewer.js", "reader.js", "viewer.css")
    )
    assert sum(parts.values()) < MOST_BYTES and packed < MOST_BYTES


def test_it_may_ask_nobody_else(service: Any) -> None:
    policy = service.client.get("/").headers["content-security-policy"]
    assert "default-src 'none'" in policy and "unsafe" not in policy
    for name in ("viewer.js", "reader.js", "viewer.css", "licenses.txt"):
        reply = service.client.get(f"/viewer/{name}")
        assert reply.status_code == 200 and reply.headers["content-encoding"] == "gzip"
        again = service.client.get(f"/viewer/{name}", headers={"If-None-Match": reply.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")
    assert service.client.get("/viewer/other.js").status_code == 404
