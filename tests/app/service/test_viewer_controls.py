"""Every control of the page, used by mouse and by keyboard; one that stands in no table fails the test."""

import fnmatch
from collections.abc import Callable, Collection, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest

from primfit import KINDS
from primfit.app.exports import FORMATS as ARTIFACTS
from tests.app.browser import DOWN, ENTER, RIGHT, SPACE, TAB, Browser, needs_browser
from tests.app.service.scans import many
from tests.app.serving import ALICE, Service, stopped, wait_for, workers
from tests.app.viewing import (
    EXAMPLE,
    FITTING,
    REFUSED,
    answered,
    drop,
    drop_file,
    offline,
    place,
    pressed,
    spot,
    visit,
)
from tests.paths import ROOT

pytestmark = [pytest.mark.browser, needs_browser]
SAMPLES = ROOT / "samples"
LONG = many(200)
"""A scan that takes some seconds."""
NAMES = """
const words = (label) => [...label.childNodes].filter((node) => !node.matches?.("input, select"))
  .map((node) => node.textContent).join(" ");
const shown = (each) => (each.labels?.[0] ? words(each.labels[0]) : each.innerText);
const name = (each) => each.getAttribute("aria-label") ?? shown(each);
const parts = "a[href], button:enabled, input:enabled, select:enabled, textarea, summary, [tabindex='0']";
window.controls = [...document.querySelectorAll(parts)];
return controls.map((each) => name(each).trim().replace(/\\s+/g, " "));
"""
MARK = """
document.querySelector("[data-used]")?.removeAttribute("data-used");
controls[arguments[0]].setAttribute("data-used", "");
"""
ASKING = """
window.asked = false;
document.querySelector(arguments[0]).addEventListener("click", () => (window.asked = true));
"""
OPTION = """
document.querySelector("[data-option]")?.removeAttribute("data-option");
const options = [...document.querySelector("[data-used]").options];
options.find((each) => each.value === arguments[0]).setAttribute("data-option", "");
"""
USED = "[data-used]"
SEED = '{"seed": 4}'
PICTURE = ".picture canvas"
Act = Callable[[Browser], None]


def click(page: Browser) -> None:
    page.click(USED)


def keys(*pressed: str) -> Act:
    """Go to the control by Tab, and press these."""

    def act(page: Browser) -> None:
        reach(page, USED)
        page.press(*pressed)

    return act


def reach(page: Browser, selector: str) -> None:
    """Press Tab until this has the focus."""
    for _ in range(100):
        if page.run("return document.activeElement.matches(arguments[0])", selector):
            return
        page.press(TAB)
    raise AssertionError(f"{selector} is not reached by Tab")


enter, space = keys(ENTER), keys(SPACE)


@dataclass(frozen=True)
class Control:
    """What is used in a state of the page, and what comes of it: `seen` changes, or has a certain value then.

    `seen` is an expression of the page; null means that it has not come about yet.
    """

    state: str
    name: str
    seen: "str | Callable[[Browser], Any]"
    becomes: Any = None
    mouse: Act = click
    keyboard: Act = enter
    before: Act | None = None
    leaves: bool = False
    """Whether the page is in another state then."""


def words(selector: str) -> str:
    return f"(document.querySelector({selector!r})?.innerText ?? '')"


FILE = words(".name")
HASH = "location.hash"
TAGS = "[...document.querySelectorAll('.tags span')].map((each) => each.innerText).join()"
MAP = "document.querySelector('.map')?.getAttribute('aria-label')"
VIEW = """new Promise((done) => {
  let [last, since] = [null, 0];
  const look = (now) => {
    const seen = document.querySelector(".tags span")?.style.transform;
    if (seen !== last) [last, since] = [seen, now];
    if (now - since < 300) requestAnimationFrame(look);
    else done(seen?.match(/[-\\d.]+px/g).map((each) => Math.round(parseFloat(each))).join());
  };
  requestAnimationFrame(look);
})"""
"""Where the first length is seen in the picture, once the view rests."""
KEY = "input[type=password]"
FITTED = "document.querySelector('.status') ? null : document.querySelector('#facts table').innerText"
LEGEND = words(".legend")
PICKED = words(".picked")
SELECTED = "document.querySelector('.note')?.innerText.match(/[\\d,]+ points selected/)?.[0]"
SAVED = "document.querySelector('#take ~ p')?.innerText.match(/.* is saved/)?.[0]"
COPIED = words("#take ~ pre")
VERDICT = words("#verdict")
STATUS = words(".status")
WELL = "document.querySelector('.problem') === null"


def chooses(option: str) -> Act:
    """Choose from a list by the mouse."""

    def act(page: Browser) -> None:
        page.run(OPTION, option)
        page.click("[data-option]")

    return act


def fills(text: str) -> tuple[Act, Act]:
    """Type into a field, by mouse and by keyboard, and leave it."""

    def by_mouse(page: Browser) -> None:
        page.click(USED)
        page.press(*text, TAB)

    return by_mouse, keys(*text, TAB)


def opens(ask: Act) -> Act:
    """Have the list of files shown, and choose one."""

    def act(page: Browser) -> None:
        page.command("Page.setInterceptFileChooserDialog", enabled=True)
        page.run(ASKING, USED)
        ask(page)
        page.wait_for("window.asked === true")
        page.command("Page.setInterceptFileChooserDialog", enabled=False)
        page.type(USED, str(SAMPLES / "tank-end.xyz"))

    return act


def click_open(page: Browser) -> None:
    page.click(".open")


def turns(page: Browser) -> None:
    page.drag(spot(page, PICTURE, 0.5, 0.6), spot(page, PICTURE, 0.6, 0.7))


def turns_away(page: Browser) -> None:
    page.run(f"return {VIEW}.then((seen) => (window.home = seen))")
    turns(page)


def in_picture(*strokes: str) -> Act:
    """Use the control by Enter, and go on in the picture."""

    def act(page: Browser) -> None:
        enter(page)
        reach(page, PICTURE)
        page.press(*strokes)

    return act


def measures(page: Browser) -> None:
    page.click(USED)
    for across in (0.45, 0.55):
        page.drag(spot(page, PICTURE, across, 0.5))


def measures_by_keys(page: Browser) -> None:
    in_picture(ENTER, RIGHT, RIGHT)(page)
    page.run(f"return {VIEW}")
    page.press(ENTER)


def draws(*corners: tuple[float, float]) -> Act:
    def act(page: Browser) -> None:
        page.click(USED)
        page.drag(*(spot(page, PICTURE, *corner) for corner in corners))

    return act


def draws_by_keys(page: Browser) -> None:
    in_picture(ENTER, RIGHT, DOWN)(page)
    page.press(RIGHT, RIGHT, shift=True)
    page.press(ENTER)


RIGHT_HALF = ((0.5, 0.05), (0.95, 0.05), (0.95, 0.95), (0.5, 0.95))


def clicks_middle(page: Browser) -> None:
    page.drag(spot(page, USED, 0.5, 0.5))


def slides(page: Browser) -> None:
    page.drag(spot(page, USED, 0.9, 0.5))


def closer(page: Browser) -> str:
    """What is seen in the middle of the picture, where nothing lies over it."""
    x, y, width, height = place(page, PICTURE)
    clip = {"x": x, "y": y + 0.25 * height, "width": width, "height": 0.5 * height, "scale": 1}
    return str(page.command("Page.captureScreenshot", clip=clip)["data"])


def types_key(page: Browser) -> None:
    page.type(KEY, ALICE)


EMPTY = [
    Control(
        "empty",
        "Open a file",
        FILE,
        "tank-end.xyz",
        opens(click_open),
        opens(enter),
        leaves=True,
    ),
    Control("empty", "Examples", FILE, "pipe.xyz", chooses("pipe"), keys(DOWN), leaves=True),
    Control("empty", "API", "location.pathname", "/docs", leaves=True),
    Control("empty", "Licenses", "location.pathname", "/viewer/licenses.txt", leaves=True),
]
PICTURES = [
    Control("fitted", "Whole view", f"{VIEW}.then((seen) => seen === home)", True, before=turns_away),
    Control("fitted", "*points*Arrow keys*", VIEW, None, turns, keys(RIGHT, RIGHT)),
    Control("fitted", "*points*Arrow keys*", PICKED, None, clicks_middle, enter),
    Control("fitted", "Surface", closer),
    Control("fitted", "Measure", f"{TAGS}.includes('measured')", True, measures, measures_by_keys),
    Control("fitted", "Dimensions", f"{TAGS}.includes('diameter')", False),
    Control("fitted", "Lasso", SELECTED, None, draws(*RIGHT_HALF), draws_by_keys),
    Control("fitted", "Box", SELECTED, None, draws((0.1, 0.1), (0.5, 0.9)), in_picture(DOWN, DOWN, ENTER)),
    Control("fitted", "colors end at", LEGEND, None, slides, keys(RIGHT)),
    Control("selected", "Fit the selection", FILE, "pipe-selection.npy", leaves=True),
]
ANSWERS = [
    Control("fitted", "Color by", LEGEND, "● inliers ○ left out", chooses("inlier"), keys(DOWN)),
    Control("fitted", "* rolled out*", PICKED, None, clicks_middle, keys(DOWN, RIGHT)),
    Control("no-fit", "* expected with *", MAP),
    Control("scan", "* rms *", VERDICT, "A plane"),
    Control("scan", "Open this segment alone", FILE, "plant-selection.npy", leaves=True),
]
ASKED = [
    *(Control("fitted", kind, HASH, None, keyboard=space) for kind in KINDS),
    Control("fitted", "Criterion", HASH, None, chooses("huber"), keys(DOWN)),
    Control("fitted", "Unit of the file", HASH, None, chooses("mm"), keys(DOWN, DOWN)),
    Control("fitted", "Tolerance*", HASH, None, *fills("2")),
    Control("fitted", "Known radius*", HASH, None, *fills("57.2")),
    Control("fitted", "Known axis", HASH, None, *fills("1 0.2 0.1")),
    Control("fitted", "Fit", FITTED),
]
TAKEN = [
    *(Control("fitted", name.replace("_", " "), SAVED) for name in ARTIFACTS),
    *(Control("fitted", f"Copy {what}", COPIED) for what in ("curl", "Python", "link with these options")),
]
WAITING = [
    Control("fitting", "Cancel", STATUS, "Canceled.", leaves=True),
    Control("scan-fitting", "Cancel", f"{STATUS}.split('.')[0]", "Canceled", leaves=True),
    Control(
        "scan-fitting",
        "Go on as a job",
        f"{STATUS}.includes('if you close this page')",
        True,
        leaves=True,
    ),
    Control("job", "Show the job of *", "document.querySelectorAll('.segments li').length", 4, leaves=True),
    Control("job", "Remove the job of *", "document.querySelectorAll('.jobs li').length", 0),
    Control("running-job", "Cancel the job of *", f"{words('.jobs')}.includes('dismissed')", True),
    Control("offline", "Try again", f"{WELL} && {VERDICT}", "A cylinder"),
    Control("key", "Key", WELL, True, *fills(ALICE + ENTER), leaves=True),
    Control("key", "Use it", WELL, True, before=types_key),
]
LINKED = [
    Control("linked", "Save the points", SAVED),
    Control("linked", "Leave out seed", HASH, ""),
]
CONTROLS = [*LINKED, *EMPTY, *PICTURES, *ANSWERS, *ASKED, *TAKEN, *WAITING]

State = Callable[[Browser, Service], AbstractContextManager[None]]


@contextmanager
def empty(page: Browser, service: Service) -> Iterator[None]:
    for job in service.client.get("/jobs").json()["jobs"]:
        dismissed(service, job["jobID"])
    visit(page, service.port)
    yield


def dismissed(service: Service, job: str) -> None:
    """Cancel a job, and remove it."""
    while service.client.delete(f"/jobs/{job}").status_code != 404:
        pass


def shown(name: str) -> State:
    @contextmanager
    def state(page: Browser, service: Service) -> Iterator[None]:
        visit(page, service.port)
        drop_file(page, SAMPLES / name)
        answered(page)
        yield

    return state


@contextmanager
def linked(page: Browser, service: Service) -> Iterator[None]:
    """An example, by a link that asks for something of which the form has no field."""
    page.open("about:blank")
    page.open(f"http://127.0.0.1:{service.port}/#{quote(SEED)}")
    page.wait_for("document.querySelector('header select') !== null")
    page.run(EXAMPLE, "pipe")
    answered(page)
    yield


@contextmanager
def selected(page: Browser, service: Service) -> Iterator[None]:
    with shown("pipe.ply")(page, service):
        pressed(page, "Lasso")
        page.drag(*(spot(page, PICTURE, *corner) for corner in RIGHT_HALF))
        page.wait_for(SELECTED)
        yield


@contextmanager
def fitting(page: Browser, service: Service) -> Iterator[None]:
    visit(page, service.port)
    wait_for(lambda: len(workers(service.pid)) == 2)
    with stopped(service):
        drop_file(page, SAMPLES / "pipe.ply")
        page.wait_for(FITTING)
        yield


@contextmanager
def scan_fitting(page: Browser, service: Service) -> Iterator[None]:
    with empty(page, service):
        drop(page, LONG, "long.csv")
        page.wait_for(FITTING)
        yield


def kept(scan: bytes, states: Collection[str]) -> State:
    @contextmanager
    def state(page: Browser, service: Service) -> Iterator[None]:
        with empty(page, service):
            job = service.client.post("/jobs?labels=auto", files={"file": ("scan.csv", scan)}).json()["jobID"]
            wait_for(lambda: service.client.get(f"/jobs/{job}").json()["status"] in states)
            visit(page, service.port)
            page.wait_for("document.querySelector('.jobs') !== null")
            yield
            dismissed(service, job)

    return state


@contextmanager
def silent(page: Browser, service: Service) -> Iterator[None]:
    with shown("pipe.ply")(page, service):
        offline(page, True)
        pressed(page, "Fit")
        page.wait_for(REFUSED)
        offline(page, False)
        yield


@contextmanager
def asked(page: Browser, service: Service) -> Iterator[None]:
    visit(page, service.port)
    page.wait_for(f"document.querySelector('{KEY}') !== null")
    yield


STATES: dict[str, State] = {
    "empty": empty,
    "fitted": shown("pipe.ply"),
    "linked": linked,
    "selected": selected,
    "no-fit": shown("corner.xyz"),
    "scan": shown("plant.csv"),
    "fitting": fitting,
    "scan-fitting": scan_fitting,
    "job": kept((SAMPLES / "plant.csv").read_bytes(), {"successful"}),
    "running-job": kept(LONG, {"accepted", "running"}),
    "offline": silent,
    "key": asked,
}


GROWING = {"scan-fitting"}
"""States in which controls come up while Tab is pressed."""


@pytest.fixture
def downloads(page: Browser, tmp_path: Path) -> Path:
    page.command("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    return tmp_path


@pytest.mark.parametrize("way", ["mouse", "keyboard"])
@pytest.mark.parametrize("state", STATES)
def test_every_control(
    viewer: Browser, service: Service, guarded_service: Service, downloads: Path, state: str, way: str
) -> None:
    service = guarded_service if state == "key" else service
    own = [control for control in CONTROLS if control.state == state]
    with ExitStack() as stack:
        stack.enter_context(STATES[state](viewer, service))
        names = viewer.run(NAMES)
        assert [name for name in names if not known(name)] == []
        if way == "keyboard" and state not in GROWING:
            assert tabbed(viewer, len(names)) == list(range(len(names)))
        for control in own:
            use(viewer, control, way)
            if control.leaves and control is not own[-1]:
                stack.close()
                stack.enter_context(STATES[state](viewer, service))
    if state == "fitted":
        wait_for(lambda: len(list(downloads.glob("pipe-*"))) == len(ARTIFACTS))
        assert all(file.stat().st_size for file in downloads.iterdir())


def known(name: str) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in [control.name for control in CONTROLS])


def tabbed(page: Browser, n: int) -> list[int]:
    """The numbers of the controls in the order in which Tab reaches them."""
    page.run("controls[0].focus()")
    order = [0]
    for _ in range(n - 1):
        page.press(TAB)
        order.append(page.run("return controls.indexOf(document.activeElement)"))
    return order


def use(page: Browser, control: Control, way: str) -> None:
    """Use a control in this way, and wait for what comes of it."""
    if control.before:
        control.before(page)
    names = page.run(NAMES)
    page.run(MARK, next(i for i, name in enumerate(names) if fnmatch.fnmatchcase(name, control.name)))
    if way == "keyboard":
        reach(page, USED)
    was = seen(page, control)
    assert was != control.becomes or control.becomes is None, control.name
    print("used:", control.name)
    getattr(control, way)(page)
    wait_for(lambda: came_about(control, was, seen(page, control)), 30)


def seen(page: Browser, control: Control) -> Any:
    return page.run(f"return {control.seen}") if isinstance(control.seen, str) else control.seen(page)


def came_about(control: Control, was: Any, now: Any) -> bool:
    return now is not None and (now != was if control.becomes is None else now == control.becomes)
