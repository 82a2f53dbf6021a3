"""Fingers, keys in the picture, less motion, and the lines that are taken along."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator

import pytest

from tests.app.browser import DOWN, ENTER, ESCAPE, HOME, RIGHT, Browser, needs_browser
from tests.app.serving import Service
from tests.app.viewing import answered, drop_file, pressed, spot, visit
from tests.paths import ROOT

pytestmark = [pytest.mark.browser, needs_browser]
SAMPLES = ROOT / "samples"
PICTURE = ".picture canvas"
PLACES = """
const tag = () => document.querySelector(".tags span").style.transform;
let last = tag();
window.places = [];
new MutationObserver(() => {
  if (tag() !== last) places.push((last = tag()));
}).observe(document.querySelector(".tags"), { subtree: true, attributes: true, attributeFilter: ["style"] });
let since = performance.now();
return new Promise((done) => {
  const look = (now) => {
    if (places.length) [places.length, since] = [0, now];
    if (now - since > 400) done(true);
    else requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
});
"""
"""Keeps each place at which the first length is seen, once the view is at rest."""
RESTS = """
return new Promise((done) => {
  let [seen, since] = [places.length, performance.now()];
  const look = (now) => {
    if (places.length !== seen) [seen, since] = [places.length, now];
    if (seen && now - since > 400) done(seen);
    else requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
});
"""
"""How many places there were, once no more are added."""
SELECTED = "document.querySelector('.note')?.innerText.match(/points selected/)"
COPIED = "document.querySelector('#take ~ pre')?.innerText ?? ''"
OUTLINE = "document.querySelector('.outline polygon')?.getAttribute('points')"


@pytest.fixture
def fingers(viewer: Browser) -> Iterator[Browser]:
    """The page on a phone, which has no mouse."""
    viewer.resize(360, 740)
    viewer.command("Emulation.setTouchEmulationEnabled", enabled=True)
    drop_file(viewer, SAMPLES / "pipe.ply")
    answered(viewer)
    yield viewer
    viewer.command("Emulation.setTouchEmulationEnabled", enabled=False)
    viewer.resize(1200)


def test_a_finger_turns_the_view_and_draws_around_points(fingers: Browser) -> None:
    fingers.run(PLACES)
    middle, aside = spot(fingers, PICTURE, 0.5, 0.5), spot(fingers, PICTURE, 0.8, 0.6)
    fingers.touch(middle, aside)
    assert fingers.run(RESTS) >= 1
    pressed(fingers, "Lasso")
    before = fingers.run(RESTS)
    corners = [(0.05, 0.05), (0.95, 0.05), (0.95, 0.95), (0.05, 0.95)]
    fingers.touch(*(spot(fingers, PICTURE, *corner) for corner in corners))
    fingers.wait_for(f"{SELECTED} !== undefined")
    assert fingers.run("return places.length") == before, "the view turned under the lasso"


def test_a_finger_picks_a_point_close_by(fingers: Browser) -> None:
    fingers.touch(spot(fingers, PICTURE, 0.5, 0.5))
    fingers.wait_for("document.querySelector('.picked') !== null")
    assert not fingers.run("return document.querySelector('.spot').hidden")


@pytest.mark.parametrize("motion", ["reduce", "no-preference"])
def test_less_motion_is_none(page: Browser, service: Service, motion: str) -> None:
    """The view is where it goes at once; else it is on its way for some frames."""
    page.prefer(reduced_motion=motion)
    visit(page, service.port)
    drop_file(page, SAMPLES / "pipe.ply")
    answered(page)
    page.run("document.querySelector(arguments[0]).focus()", PICTURE)
    page.run(PLACES)
    page.press(RIGHT)
    turned = page.run(RESTS)
    page.press(HOME)
    back = page.run(RESTS) - turned
    page.prefer()
    if motion == "reduce":
        assert (turned, back) == (1, 1)
    else:
        assert turned > 2 and back >= 1


@pytest.mark.parametrize("tool", ["Lasso", "Box"])
def test_a_box_by_keys(viewer: Browser, tool: str) -> None:
    """Arrows move it, with Shift they stretch it, Escape ends it."""
    drop_file(viewer, SAMPLES / "pipe.ply")
    answered(viewer)
    pressed(viewer, tool)
    viewer.run("document.querySelector(arguments[0]).focus()", PICTURE)
    viewer.press(ENTER)
    first = viewer.run(f"return {OUTLINE}")
    viewer.press(RIGHT, DOWN)
    moved = viewer.run(f"return {OUTLINE}")
    viewer.press(RIGHT, DOWN, shift=True)
    stretched = viewer.run(f"return {OUTLINE}")
    assert size(first) == size(moved) != size(stretched)
    assert first != moved
    viewer.press(ESCAPE)
    assert viewer.run(f"return {OUTLINE}") is None
    assert viewer.run("return document.querySelectorAll('.tools [aria-pressed=true]').length") == 2
    viewer.press(ENTER)
    viewer.wait_for("document.querySelector('.picked') !== null")


def size(corners: str) -> tuple[float, float]:
    (left, top), _, (right, bottom), _ = (map(float, each.split(",")) for each in corners.split(" "))
    return round(right - left, 6), round(bottom - top, 6)


def copied(page: Browser, what: str) -> str:
    pressed(page, f"Copy {what}")
    return str(page.run(f"return {COPIED}"))


@pytest.mark.skipif(shutil.which("curl") is None, reason="needs curl")
@pytest.mark.parametrize("file", ["pipe.ply", "short-arc.csv", "plant.csv"])
def test_the_copied_lines_give_the_same_kinds(viewer: Browser, file: str) -> None:
    """Of one cloud with an option, and of a scan."""
    drop_file(viewer, SAMPLES / file)
    answered(viewer)
    viewer.run("document.querySelectorAll('fieldset input')[4].click()")
    pressed(viewer, "Fit")
    answered(viewer)
    command, program = copied(viewer, "curl"), copied(viewer, "Python")
    assert "torus" not in command and "cone" in command
    asked = subprocess.check_output(["sh", "-c", f"{command} -sS"], cwd=SAMPLES)
    answers = [json.loads(line) for line in asked.splitlines()]
    kinds = [each.get("answer", each)["primitive"]["kind"] for each in answers if "summary" not in each]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    printed = subprocess.check_output(
        [sys.executable, "-c", program], cwd=SAMPLES, env=environment, text=True
    )
    said = [line for line in printed.lower().splitlines() if line]
    assert kinds and all(kind in line for kind, line in zip(kinds, said, strict=True))


def test_the_copied_link_brings_the_options(viewer: Browser) -> None:
    drop_file(viewer, SAMPLES / "pipe.ply")
    answered(viewer)
    viewer.run("document.querySelectorAll('fieldset input')[4].click()")
    link = copied(viewer, "link with these options")
    viewer.open("about:blank")
    viewer.open(link)
    viewer.wait_for("document.querySelector('header select') !== null")
    drop_file(viewer, SAMPLES / "pipe.ply")
    answered(viewer)
    assert viewer.run("return document.querySelectorAll('fieldset input:checked').length") == 4
