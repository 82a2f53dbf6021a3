"""The keyboard goes on where a control was that is gone; a window of another size shows as much."""

import numpy as np
import pytest

from tests.app.browser import ENTER, RIGHT, TAB, Browser, needs_browser
from tests.app.processes import needs_proc
from tests.app.service.scans import csv, many
from tests.app.serving import Service, stopped
from tests.app.viewing import FITTING, answered, drop, drop_file, pressed, visit
from tests.paths import ROOT

pytestmark = [pytest.mark.browser, needs_browser]
PIPE = ROOT / "samples" / "pipe.ply"
LOST = "return document.activeElement === document.body"
PRESS = """
const buttons = [...document.querySelectorAll("button")];
buttons.find((each) => each.innerText === arguments[0]).focus();
"""
REACH = """
return new Promise((done) => setTimeout(() => {
  const tags = [...document.querySelectorAll(".tags span")].map((each) => each.style.transform);
  done(tags.map((each) => each.match(/[-\\d.]+px/g).map(parseFloat)));
}, 700));
"""
"""Where lengths are seen [pixels], once the view rests."""


def press(page: Browser, words: str) -> None:
    """Press a button by the keyboard."""
    page.run(PRESS, words)
    page.press(ENTER)


@needs_proc
def test_cancel_leaves_the_keyboard_in_the_answer(viewer: Browser, service: Service) -> None:
    with stopped(service):
        drop_file(viewer, PIPE)
        viewer.wait_for(FITTING)
        press(viewer, "Cancel")
        viewer.wait_for("document.querySelector('.status')?.innerText === 'Canceled.'")
        assert not viewer.run(LOST)
        viewer.press(TAB)
        assert viewer.run("return document.activeElement.matches('aside fieldset input')")


def test_a_selection_that_is_fitted_leaves_it_by_the_picture(viewer: Browser) -> None:
    drop_file(viewer, PIPE)
    answered(viewer)
    pressed(viewer, "Box")
    viewer.run("document.querySelector('.picture canvas').focus()")
    viewer.press(ENTER, ENTER)
    press(viewer, "Fit the selection")
    viewer.wait_for("document.querySelector('.name').innerText === 'pipe-selection.npy'")
    answered(viewer)
    assert not viewer.run(LOST)
    viewer.press(TAB)
    assert viewer.run("return document.activeElement.innerText") == "Whole view"


def test_a_job_that_is_removed_leaves_it_in_the_list(viewer: Browser, service: Service) -> None:
    for _ in range(2):
        service.client.post("/jobs?labels=auto", files={"file": ("scan.csv", many(2))})
    visit(viewer, service.port)
    viewer.wait_for("document.querySelectorAll('.jobs li').length >= 2")
    viewer.wait_for("document.querySelector('.jobs').innerText.includes('Remove')")
    n = viewer.run("return document.querySelectorAll('.jobs li').length")
    press(viewer, "Remove")
    viewer.wait_for(f"document.querySelectorAll('.jobs li').length === {n - 1}")
    viewer.press(TAB)
    assert viewer.run("return document.activeElement.matches('.jobs button')")


def test_who_has_clicked_elsewhere_is_left_there(viewer: Browser, service: Service) -> None:
    with stopped(service):
        drop_file(viewer, PIPE)
        viewer.wait_for(FITTING)
        viewer.run(PRESS, "Cancel")
        viewer.drag((500, 300))
        viewer.run("document.activeElement.blur()")
        pressed(viewer, "Cancel")
        viewer.wait_for("document.querySelector('.status')?.innerText === 'Canceled.'")
        assert viewer.run(LOST)


def test_a_window_of_another_size_shows_as_much(viewer: Browser) -> None:
    """As *Whole view* does there; and what was closer stays closer."""
    drop_file(viewer, PIPE)
    answered(viewer)
    wide = np.array(viewer.run(REACH))
    viewer.resize(500)
    narrow = np.array(viewer.run(REACH))
    pressed(viewer, "Whole view")
    assert narrow == pytest.approx(np.array(viewer.run(REACH)), abs=1)
    viewer.run("document.querySelector('.picture canvas').focus()")
    viewer.press("+")
    closer = np.array(viewer.run(REACH))
    assert np.abs(closer - narrow).max() > 5
    viewer.press("-")
    viewer.run(REACH)
    viewer.resize(1200)
    assert np.array(viewer.run(REACH)) == pytest.approx(wide, abs=2)


def test_a_point_far_from_the_origin_has_all_its_digits(viewer: Browser) -> None:
    """In meters of UTM; and in a scan it says of which segment it is."""
    grid = np.array([[i % 9, i // 9, 0.0] for i in range(81)]) * 0.125
    points = np.vstack([grid, grid + np.array([5, 0, 0])]) + np.array([500123.4375, 5400321.5625, 312.0])
    drop(viewer, csv(points, [7] * 81 + [8] * 81), "utm.csv")
    answered(viewer)
    viewer.run("document.querySelectorAll('.segments button')[1].click()")
    viewer.wait_for("document.querySelector('.map') !== null")
    viewer.run("document.querySelector('.map').focus()")
    viewer.press(RIGHT)
    viewer.wait_for("document.querySelector('.picked') !== null")
    told = viewer.run("return document.querySelector('.picked').innerText")
    number, place = told.removeprefix("Point ").split(",")[0].split(":")
    assert [float(each) for each in place.split()] == points[int(number) - 1].tolist()
    assert ", segment 8, residual " in told
