"""A report on a phone, in a real browser: nothing is cut off at the right, or has to be moved sideways."""

from collections.abc import Iterator
from pathlib import Path

import pytest

import primfit
from tests.app.browser import WITHOUT_GRAPHICS, Browser, browser, needs_browser
from tests.paths import ROOT

pytestmark = [pytest.mark.browser, needs_browser]

CLOUDS = (
    "floor.csv",
    "pipe.ply",
    "tank-end.xyz",
    "nozzle.pcd",
    "handwheel.xyz",
    "short-arc.csv",
    "corner.xyz",
)
"""Of all five kinds, one that is ambiguous, and one that is none of them."""

TOO_WIDE = """
return [...document.querySelectorAll("body, body *")]
  .filter((each) => each.clientWidth > 0 && each.scrollWidth > each.clientWidth + 1)
  .map((each) => each.textContent.slice(0, 80));
"""


@pytest.fixture(scope="module")
def phone(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile"), WITHOUT_GRAPHICS) as started:
        started.resize(375, 800)
        yield started


@pytest.mark.parametrize("cloud", CLOUDS)
def test_a_report_is_as_wide_as_a_phone(phone: Browser, cloud: str, tmp_path: Path) -> None:
    answer = primfit.fit(ROOT / "samples" / cloud, unit="mm")
    page = tmp_path / "report.html"
    page.write_bytes(primfit.export(answer, ["report"])["report"])
    phone.open(page.as_uri())
    assert phone.run("return document.documentElement.scrollWidth") == 375
    assert phone.run(TOO_WIDE) == []
