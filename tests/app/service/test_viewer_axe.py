"""Nothing in any state of the page keeps people out, by axe-core: wide and narrow, light and dark."""

from collections.abc import Iterator

import pytest

from tests.app import npm
from tests.app.browser import Browser, needs_browser
from tests.app.processes import needs_proc
from tests.app.serving import Service, stopped, wait_for, workers
from tests.app.viewer_states import HELD, PLAIN, SAMPLES, key_asked
from tests.app.viewing import FITTING, drop_file, visit

pytestmark = [pytest.mark.browser, needs_browser, npm.needs_node]
AXE = npm.VIEWER / "node_modules" / "axe-core" / "axe.min.js"
WIDTHS = (360, 1200)


@pytest.fixture(autouse=True)
def as_it_was(viewer: Browser, viewer_sources: None) -> Iterator[None]:
    yield
    viewer.prefer()
    viewer.resize(1200)


def keeps_nobody_out(page: Browser) -> None:
    page.run(AXE.read_text())
    for width in WIDTHS:
        page.resize(width)
        for scheme in ("light", "dark"):
            page.prefer(color_scheme=scheme)
            found = page.run("return axe.run().then(({ violations }) => violations)")
            said = [(each["id"], [node["html"] for node in each["nodes"]][:3]) for each in found]
            assert said == [], (width, scheme)


@pytest.mark.parametrize("state", PLAIN)
def test_a_state(viewer: Browser, service: Service, state: str) -> None:
    PLAIN[state](viewer, service)
    keeps_nobody_out(viewer)


@needs_proc
@pytest.mark.parametrize("state", HELD)
def test_a_state_while_it_is_fitted(viewer: Browser, service: Service, state: str) -> None:
    wait_for(lambda: len(workers(service.pid)) == 2)
    with stopped(service):
        drop_file(viewer, SAMPLES / HELD[state])
        viewer.wait_for(FITTING)
        keeps_nobody_out(viewer)


def test_a_key_is_asked_for(viewer: Browser, guarded_service: Service) -> None:
    visit(viewer, guarded_service.port)
    key_asked(viewer, guarded_service)
    keeps_nobody_out(viewer)
