"""The page at / in a real browser: it shows every state there is, and asks the service alone."""

import base64
import gzip
import io
import itertools
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest
from PIL import Image

from tests.app import npm
from tests.app.browser import IN_SOFTWARE, Browser, browser, needs_browser
from tests.app.serving import ALICE
from tests.paths import ROOT

pytestmark = [pytest.mark.browser, needs_browser]
MOST_BYTES = 200_000
"""All scripts and styles together, packed as they are sent."""
GROUND = [0x23, 0x28, 0x2E]
DROP = """
const bytes = Uint8Array.from(atob(arguments[0]), (letter) => letter.charCodeAt(0));
const transfer = new DataTransfer();
transfer.items.add(new File([bytes], arguments[1]));
document.body.dispatchEvent(
  new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
"""
CHOOSE = """
const [list, value] = [document.querySelector(arguments[0]), arguments[1]];
list.value = value;
list.dispatchEvent(new Event("change", { bubbles: true }));
"""
PRESS = """
const buttons = [...document.querySelectorAll("button")];
buttons.find((each) => each.textContent.startsWith(arguments[0])).click();
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
VERDICT = "document.querySelector('#verdict')?.textContent"


@pytest.fixture(scope="module")
def page(service: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile"), IN_SOFTWARE) as started:
        started.resize(1200)
        yield started


_visits = itertools.count()


@pytest.fixture
def viewer(page: Browser, service: Any) -> Iterator[Browser]:
    """The page as it is at first; nothing was complained of when it is left, and nobody else was asked."""
    _open(page, service)
    page.complaints()
    page.network()
    yield page
    # What is refused is an error for Chromium, too.
    assert [each for each in page.complaints() if "Failed to load resource" not in each] == []
    assert page.hosts() <= {"127.0.0.1"}


def _open(page: Browser, service: Any) -> None:
    page.open(f"http://127.0.0.1:{service.port}/?{next(_visits)}")
    page.wait_for("document.querySelector('header select') !== null")


def _drop(page: Browser, content: bytes, name: str) -> None:
    page.run(DROP, base64.b64encode(content).decode(), name)


def _answered(page: Browser) -> str:
    page.wait_for("!document.querySelector('.status') && document.querySelector('#verdict, .segments li')")
    return str(page.run(f"return {VERDICT}"))


def _text(page: Browser) -> str:
    return str(page.run("return document.querySelector('aside').innerText"))


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
    assert _answered(viewer) == f"A {kind}"
    assert _lit(viewer) > 3000
    text = _text(viewer)
    assert "What was tried" in text and "left out as outliers" in text and "accepted" in text
    assert viewer.run("return document.querySelectorAll('.histogram rect').length") == 41
    shown = f"{kind} rolled out"
    assert shown in viewer.run("return document.querySelector('.map').getAttribute('aria-label')")


def test_no_fit_says_so_and_its_steps_can_be_looked_at(viewer: Browser) -> None:
    _drop(viewer, (ROOT / "samples" / "corner.xyz").read_bytes(), "corner.xyz")
    assert _answered(viewer).startswith("No fit; closest is a ")
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
    _drop(viewer, (ROOT / "samples" / "short-arc.csv").read_bytes(), "short-arc.csv")
    said = _answered(viewer)
    if "or another" in said:
        assert "Also possible: a " in _text(viewer)


def test_what_the_service_refuses_is_told_in_its_words(viewer: Browser) -> None:
    _drop(viewer, b"x,y,z\n1,2,3\n", "one.csv")
    viewer.wait_for("document.querySelector('.problem') !== null")
    assert "1 point" in _text(viewer)


def test_options_are_asked_for_and_stand_in_the_link(viewer: Browser, service: Any) -> None:
    viewer.run(CHOOSE, "header select", "pipe")
    _answered(viewer)
    for kind in ("plane", "sphere", "cylinder", "torus"):
        place = ["plane", "sphere", "cylinder", "cone", "torus"].index(kind)
        viewer.run(f"document.querySelectorAll('fieldset input')[{place}].click()")
    viewer.run(PRESS, "Fit")
    viewer.wait_for(f"{VERDICT} && !document.querySelector('.status') && !{VERDICT}.includes('cylinder')")
    assert "cone" in viewer.run(f"return {VERDICT}")
    link = viewer.run("return location.hash")
    assert "cone" in link and "plane" not in link


def test_a_scan_is_fitted_segment_by_segment(viewer: Browser) -> None:
    _drop(viewer, (ROOT / "samples" / "plant.csv").read_bytes(), "plant.csv")
    viewer.wait_for(
        "document.querySelectorAll('.segments li').length === 4 && !document.querySelector('.status')"
    )
    assert "1 plane, 1 cylinder, 1 sphere, 1 cone" in _text(viewer)
    viewer.run("document.querySelectorAll('.segments button')[2].click()")
    viewer.wait_for(f"{VERDICT} === 'A sphere'")
    viewer.run(PRESS, "Open this segment alone")
    viewer.wait_for("!document.querySelector('.segments') && !document.querySelector('.status')")
    assert _answered(viewer) == "A sphere"
    assert "900" in _text(viewer)


def test_a_lasso_selects_what_is_fitted(viewer: Browser) -> None:
    """The right half of a pipe is a pipe of half the points, about."""
    viewer.run(CHOOSE, "header select", "pipe")
    _answered(viewer)
    viewer.run(PRESS, "Lasso")
    viewer.run(LASSO, [[0.5, 0.01], [0.99, 0.01], [0.99, 0.99], [0.5, 0.99]])
    viewer.wait_for(
        "[...document.querySelectorAll('button')].some((b) => b.textContent === 'Fit the selection')"
    )
    viewer.run(PRESS, "Fit the selection")
    viewer.wait_for("document.querySelector('.name').textContent === 'pipe-selection.npy'")
    assert _answered(viewer) == "A cylinder"
    count = "document.querySelectorAll('caption + tbody')[1].rows[0].cells[1].textContent"
    n_points = int(viewer.run(f"return {count}").replace(",", ""))
    assert 300 < n_points < 1200


def test_a_key_is_asked_for(page: Browser, guarded_service: Any) -> None:
    _open(page, guarded_service)
    page.wait_for("document.querySelector('input[type=password]') !== null")
    page.type("input[type=password]", ALICE)
    page.run(PRESS, "Use it")
    page.wait_for("document.querySelector('.problem') === null")
    page.run(CHOOSE, "header select", "ball")
    assert _answered(page) == "A sphere"
    page.complaints()


def test_points_are_pasted(viewer: Browser) -> None:
    rows = (ROOT / "samples" / "tank-end.xyz").read_text()
    viewer.run(
        "const data = new DataTransfer(); data.setData('text/plain', arguments[0]);"
        "dispatchEvent(new ClipboardEvent('paste', { clipboardData: data }))",
        rows,
    )
    assert _answered(viewer) == "A sphere"


def test_a_file_that_only_the_service_reads_is_shown(viewer: Browser) -> None:
    packed = gzip.compress((ROOT / "samples" / "pipe.ply").read_bytes())
    _drop(viewer, packed, "pipe.ply.gz")
    assert _answered(viewer) == "A cylinder"
    assert _lit(viewer) > 3000


def test_the_view_is_turned_by_keys(viewer: Browser) -> None:
    viewer.run(CHOOSE, "header select", "pipe")
    _answered(viewer)
    before = viewer.picture()
    viewer.run(
        "const canvas = document.querySelector('.picture canvas'); canvas.focus();"
        "for (let i = 0; i < 5; i++) canvas.dispatchEvent("
        "new KeyboardEvent('keydown', { key: 'ArrowRight', bubbles: true, cancelable: true }))"
    )
    viewer.wait_for("new Promise((done) => setTimeout(() => done(true), 800))")
    assert viewer.picture() != before


def test_it_fits_on_a_phone(viewer: Browser) -> None:
    viewer.resize(360)
    viewer.run(CHOOSE, "header select", "elbow")
    _answered(viewer)
    assert viewer.run("return document.documentElement.scrollWidth") == 360
    viewer.resize(1200)


def test_all_that_is_sent_is_small(page: Browser, service: Any) -> None:
    page.network()
    page.command("Network.clearBrowserCache")
    _open(page, service)
    page.run(CHOOSE, "header select", "pipe")
    _answered(page)
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


@npm.needs_node
@pytest.mark.parametrize("width", [360, 1200])
@pytest.mark.parametrize("file", [None, "pipe.ply", "plant.csv", "corner.xyz"])
def test_nothing_keeps_people_out(
    viewer: Browser, viewer_sources: None, file: str | None, width: int
) -> None:
    """By axe-core, in light and dark."""
    viewer.resize(width)
    if file is not None:
        _drop(viewer, (ROOT / "samples" / file).read_bytes(), file)
        _answered(viewer)
    viewer.run((npm.VIEWER / "node_modules" / "axe-core" / "axe.min.js").read_text())
    for scheme in ("light", "dark"):
        viewer.command(
            "Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}]
        )
        found = viewer.run("return axe.run().then(({ violations }) => violations)")
        said = [(each["id"], [node["html"] for node in each["nodes"]][:3]) for each in found]
        assert said == [], scheme
    viewer.resize(1200)


def test_it_may_ask_nobody_else(service: Any) -> None:
    policy = service.client.get("/").headers["content-security-policy"]
    assert "default-src 'none'" in policy and "unsafe" not in policy
    for name in ("viewer.js", "reader.js", "viewer.css", "licenses.txt"):
        reply = service.client.get(f"/viewer/{name}")
        assert reply.status_code == 200 and reply.headers["content-encoding"] == "gzip"
        again = service.client.get(f"/viewer/{name}", headers={"If-None-Match": reply.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")
    assert service.client.get("/viewer/other.js").status_code == 404
