"""What a link may ask for, and the lines that are taken along: of points without a file, of odd names."""

import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path
from urllib.parse import quote

import pytest

from tests.app.browser import ENTER, Browser, needs_browser
from tests.app.serving import Service, wait_for
from tests.app.viewing import EXAMPLE, VERDICT, answered, drop, drop_file, pressed, text
from tests.paths import ROOT

pytestmark = [pytest.mark.browser, needs_browser]
PIPE = ROOT / "samples" / "pipe.ply"
OTHERS = "[...document.querySelectorAll('.other span')].map((each) => each.innerText)"
COPIED = "document.querySelector('#take ~ pre').innerText"
LINKS = {
    '{"seed": 4, "max_error": 1e-7}': ["seed: 4", "max error: 1e-7"],
    '{"constraints": {"radius": {"min": 50, "max": 60}}}': ['constraints: {"radius":{"min":50,"max":60}}'],
    '{"constraints": {"axis": {}}}': ['constraints: {"axis":{}}'],
    '{"kinds": 5}': ["kinds: 5"],
    '{"tolerance": {"a": 1}, "unit": "ell"}': ['tolerance: {"a":1}', 'unit: "ell"'],
}


def follow(page: Browser, service: Service, link: str) -> None:
    page.open("about:blank")
    page.open(f"http://127.0.0.1:{service.port}/#{quote(link)}")
    page.wait_for("document.querySelector('header select') !== null")


@pytest.mark.parametrize("link", LINKS)
def test_what_no_field_shows_is_told_and_can_be_left_out(page: Browser, service: Service, link: str) -> None:
    """By the keyboard; whatever a link holds, the page goes on."""
    follow(page, service, link)
    drop_file(page, PIPE)
    page.wait_for("document.querySelector('#verdict, .problem') !== null")
    assert page.run(f"return {OTHERS}") == LINKS[link]
    for _ in LINKS[link]:
        page.run("document.querySelector('.other button').focus()")
        page.press(ENTER)
        assert page.run("return document.activeElement.tagName") == "FORM"
    pressed(page, "Fit")
    page.wait_for(f"{VERDICT} === 'A cylinder'")
    assert page.run("return location.hash") == ""
    assert [line for line in page.complaints() if "status of 422" not in line] == []


def test_a_link_that_is_followed_on_the_open_page(viewer: Browser) -> None:
    viewer.run("location.hash = encodeURIComponent('{\"tolerance\": 2}')")
    drop_file(viewer, PIPE)
    answered(viewer)
    viewer.wait_for("document.querySelector('.band') !== null")
    assert viewer.run("return document.querySelector('form input[inputmode]').value") == "2"


def test_what_is_known_has_no_doubt_and_the_rest_has(page: Browser, service: Service) -> None:
    """The doubts of the answer: of a free axis an angle, of the place a length, of a known axis none."""
    seen = []
    for link in ("{}", '{"constraints": {"axis": {"direction": [1, 0.2, 0.1], "max_angle": 0}}}'):
        follow(page, service, link)
        drop_file(page, PIPE)
        answered(page)
        rows = page.run(
            "return [...document.querySelectorAll('#verdict ~ table tr')].map((r) => r.innerText)"
        )
        seen += [row.strip() for row in rows[:2]]
    body = {"file": (PIPE.name, PIPE.read_bytes())}
    doubt = service.client.post("/fit", files=body).json()["uncertainty"]
    angle = math.degrees(doubt["direction"]["radius_95"])
    axis, point, known_axis, known_point = seen
    assert float(axis.split("±")[1].strip("° ")) == pytest.approx(angle, rel=0.05)
    length = float(point.split("±")[1].split()[0])
    assert length == pytest.approx(doubt["position"]["radius_95"], rel=0.05)
    assert "±" not in known_axis and "across the axis" in known_point


def _kind_and_radius(page: Browser) -> tuple[str, float]:
    shown = text(page).split("radius\t")[1].split()[0]
    return answered(page).removeprefix("A "), float(shown)


@pytest.mark.skipif(shutil.which("curl") is None, reason="needs curl")
def test_points_without_a_file_are_saved_for_the_copied_lines(viewer: Browser, tmp_path: Path) -> None:
    viewer.command("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    viewer.run(EXAMPLE, "pipe")
    answered(viewer)
    pressed(viewer, "Save the points")
    wait_for(lambda: (tmp_path / "pipe.xyz").exists())
    kind, radius = _kind_and_radius(viewer)
    pressed(viewer, "Copy curl")
    command = f"{viewer.run(f'return {COPIED}')} -sS"
    told = json.loads(subprocess.check_output(["sh", "-c", command], cwd=tmp_path))["primitive"]
    assert (told["kind"], told["radius"]) == (kind, pytest.approx(radius, abs=0.001))
    pressed(viewer, "Copy Python")
    program = f"{viewer.run(f'return {COPIED}')}\nprint(answer.primitive.radius)"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    printed = subprocess.check_output([sys.executable, "-c", program], cwd=tmp_path, env=environment)
    assert float(printed.split()[-1]) == told["radius"]
    drop_file(viewer, PIPE)
    answered(viewer)
    assert "Save the points" not in text(viewer)


@pytest.mark.skipif(shutil.which("curl") is None, reason="needs curl")
@pytest.mark.parametrize("name", ["a,b.csv", "a;type=b.csv", 'it\'s "c".csv', "a\\b.csv", "@ ü.csv"])
def test_any_name_of_a_file_is_one_name_to_curl(viewer: Browser, tmp_path: Path, name: str) -> None:
    content = (ROOT / "samples" / "short-arc.csv").read_bytes()
    (tmp_path / name).write_bytes(content)
    drop(viewer, content, name)
    answered(viewer)
    pressed(viewer, "Copy curl")
    command = f"{viewer.run(f'return {COPIED}')} -sS"
    told = json.loads(subprocess.check_output(["sh", "-c", command], cwd=tmp_path))
    assert (told["status"], told["primitive"]["kind"]) == ("ambiguous", "cylinder")
