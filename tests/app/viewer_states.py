"""Pictures of every state of the page at /, to look at: `python -m tests.app.viewer_states OUT [STATE ...]`.

At three sizes, light and dark. After a change of the page, look at those that it concerns.
"""

import base64
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from tests.app.browser import ENTER, IN_SOFTWARE, Browser, browser
from tests.app.service.scans import many
from tests.app.serving import ALICE, Service, running, stopped
from tests.app.viewing import FITTING, REFUSED, answered, drop, drop_file, offline, pressed, spot, visit
from tests.paths import ROOT

SAMPLES = ROOT / "samples"
SIZES = {"phone": (360, 740), "tablet": (820, 1180), "desktop": (1440, 900)}
WHOLE = """
const tools = [...document.querySelectorAll(".tools button")];
tools.find((each) => each.textContent === "Whole view")?.click();
"""
DRAWN = "return new Promise((done) => setTimeout(() => requestAnimationFrame(() => done(true)), 500))"
"""When the view has come to rest; nothing but the picture says so."""
State = Callable[[Browser, Service], None]


def shown(name: str) -> State:
    def state(page: Browser, service: Service) -> None:
        drop_file(page, SAMPLES / name)
        answered(page)

    return state


def empty(page: Browser, service: Service) -> None:
    page.wait_for("document.querySelector('.status h2') !== null")


def picked(page: Browser, service: Service) -> None:
    shown("pipe.ply")(page, service)
    pressed(page, "Measure")
    for across in (0.4, 0.6):
        page.drag(spot(page, ".picture canvas", across, 0.5))


def below(page: Browser, service: Service) -> None:
    shown("pipe.ply")(page, service)
    page.run("document.querySelector('aside').scrollTop = 1e6; scrollTo(0, 1e6)")


def with_tolerance(page: Browser, service: Service) -> None:
    shown("plate.csv")(page, service)
    page.type("form input[inputmode]", f"2{ENTER}")
    page.wait_for("document.querySelector('.band') !== null")


def step(page: Browser, service: Service) -> None:
    shown("corner.xyz")(page, service)
    page.run("document.querySelectorAll('.attempts button')[1].click()")


def segment(page: Browser, service: Service) -> None:
    shown("plant.csv")(page, service)
    page.run("document.querySelectorAll('.segments button')[2].click()")


def many_segments(page: Browser, service: Service) -> None:
    drop(page, many(30), "many.csv")
    answered(page)


def boxed(page: Browser, service: Service) -> None:
    shown("plant.csv")(page, service)
    pressed(page, "Box")
    page.drag(spot(page, ".picture canvas", 0.5, 0.3), spot(page, ".picture canvas", 0.9, 0.8))


def outlined(page: Browser, service: Service) -> None:
    shown("pipe.ply")(page, service)
    pressed(page, "Box")
    page.run("document.querySelector('.picture canvas').focus()")
    page.press(ENTER)


def canceled(page: Browser, service: Service) -> None:
    with stopped(service):
        drop_file(page, SAMPLES / "pipe.ply")
        page.wait_for(FITTING)
        pressed(page, "Cancel")


def refused(page: Browser, service: Service) -> None:
    drop(page, b"x,y,z\n1,2,3\n", "one.csv")
    page.wait_for(REFUSED)


def unreadable(page: Browser, service: Service) -> None:
    drop(page, b"\x00\x01\x02 no cloud at all \xff" * 20, "photo.jpg")
    page.wait_for(REFUSED)


def bad_option(page: Browser, service: Service) -> None:
    shown("pipe.ply")(page, service)
    page.type("form input[inputmode]", f"0{ENTER}")
    page.wait_for(REFUSED)


def unanswered(page: Browser, service: Service) -> None:
    shown("pipe.ply")(page, service)
    offline(page, True)
    pressed(page, "Fit")
    page.wait_for(REFUSED)
    offline(page, False)


def too_large(page: Browser, service: Service) -> None:
    drop(page, many(10, 4000), "large.csv")
    page.wait_for(REFUSED)


def with_jobs(page: Browser, service: Service) -> None:
    content = (SAMPLES / "plant.csv").read_bytes()
    for _ in range(2):
        service.client.post("/jobs?labels=auto", files={"file": ("plant.csv", content)})
    visit(page, service.port)
    page.wait_for("document.querySelector('.jobs') !== null")


def key_asked(page: Browser, service: Service) -> None:
    page.wait_for("document.querySelector('input[type=password]') !== null")


PLAIN: dict[str, State] = {
    "empty": empty,
    "fitted": shown("pipe.ply"),
    "fitted-below": below,
    "plane": shown("floor.csv"),
    "sphere": shown("tank-end.xyz"),
    "cone": shown("nozzle.pcd"),
    "torus": shown("handwheel.xyz"),
    "measured": picked,
    "tolerance": with_tolerance,
    "ambiguous": shown("short-arc.csv"),
    "no-fit": shown("corner.xyz"),
    "no-fit-step": step,
    "scan": shown("plant.csv"),
    "scan-segment": segment,
    "scan-many": many_segments,
    "selected": boxed,
    "outlined": outlined,
    "canceled": canceled,
    "one-point": refused,
    "unreadable": unreadable,
    "bad-option": bad_option,
    "offline": unanswered,
    "jobs": with_jobs,
}
HELD = {"fitting": "pipe.ply", "scan-fitting": "plant.csv"}
"""States that last as long as the service does nothing."""


def keep(page: Browser, name: str, folder: Path) -> None:
    """Pictures of what is shown: of the whole page on a phone, else of the window."""
    for size, (width, height) in SIZES.items():
        page.resize(width, height)
        for scheme in ("light", "dark"):
            page.prefer(color_scheme=scheme)
            page.run(WHOLE)
            page.run(DRAWN)
            taken = page.command("Page.captureScreenshot", captureBeyondViewport=size == "phone")
            (folder / f"{name}-{size}-{scheme}.png").write_bytes(base64.b64decode(taken["data"]))
    page.resize(*SIZES["desktop"])


def keep_all(
    page: Browser, service: Service, folder: Path, wanted: list[str], states: dict[str, State]
) -> None:
    for name, state in states.items():
        if wanted and name not in wanted:
            continue
        visit(page, service.port)
        state(page, service)
        keep(page, name, folder)
        print(name, flush=True)


def keep_held(page: Browser, service: Service, folder: Path, wanted: list[str]) -> None:
    for name, file in HELD.items():
        if wanted and name not in wanted:
            continue
        visit(page, service.port)
        with stopped(service):
            drop_file(page, SAMPLES / file)
            page.wait_for(FITTING)
            keep(page, name, folder)


def main(folder: Path, wanted: list[str]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch, browser(Path(scratch, "profile"), IN_SOFTWARE) as page:
        page.resize(*SIZES["desktop"])
        bodies = Path(scratch, "bodies")
        with running(bodies, workers=2, jobs_path=scratch) as service:
            keep_all(page, service, folder, wanted, PLAIN)
            keep_held(page, service, folder, wanted)
        with running(bodies, workers=1, max_body_bytes=2**20) as service:
            keep_all(page, service, folder, wanted, {"too-large": too_large})
        with running(bodies, workers=1, api_keys=ALICE) as service:
            keep_all(page, service, folder, wanted, {"key": key_asked})


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
