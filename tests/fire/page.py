"""How fast the page at / is with large files, and how much memory it takes: `python -m tests.fire.page`.

Chromium draws in software, on the cores that the service has, too.
"""

import argparse
import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, sleep

import primfit
from primfit.benchmark.service import csv, npy
from tests.app.browser import IN_SOFTWARE, Browser, browser
from tests.app.serving import running
from tests.fire.report import Report, reported
from tests.fire.traffic import points
from tests.fire.watching import pss

MANY, SOME, TURNS = 1_000_000, 200_000, 3
TO_PAINT, FRAMES, MEMORY, BEYOND = 2.0, 10.0, 300.0, 1.5
"""Bars: seconds, frames a second, MB, seconds."""
WATCH = """
addEventListener("change", () => { window.chosen = performance.now(); }, true);
const gl = document.querySelector(".picture canvas").getContext("webgl2");
new PerformanceObserver(() => {
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  window.painted ??= performance.now();
}).observe({ type: "mark" });
"""
"""Notes when a file was chosen, and when the first picture of its points was done: it can be read."""
SETTLED = "performance.getEntriesByType('resource').some(({ name }) => name.endsWith('/capabilities'))"
ANSWERED = "!document.querySelector('.status') && document.querySelector('#verdict')"
COUNT = """
window.drawn ??= (() => {
  const gl = document.querySelector(".picture canvas").getContext("webgl2");
  const draw = gl.drawArrays.bind(gl);
  gl.drawArrays = (mode, ...range) => { window.drawn += mode === gl.POINTS; draw(mode, ...range); };
  return 0;
})();
return window.drawn;
"""
"""How often points were drawn since this was run first: once in each frame."""


@contextmanager
def opened(folder: Path) -> Iterator[tuple[Browser, str]]:
    """A browser, and the address of a service."""
    with running(folder / "bodies", workers=2) as service, browser(folder / "profile", IN_SOFTWARE) as page:
        page.resize(1200)
        yield page, f"http://127.0.0.1:{service.port}/"


def choose(page: Browser, url: str, file: Path) -> float:
    """Open the page anew and choose a file on it; returns when, in the time of `perf_counter`."""
    page.open("about:blank")
    page.open(url)
    page.wait_for(SETTLED)
    sleep(1.0)
    page.run(WATCH)
    started = perf_counter()
    page.type("input[type=file]", str(file))
    return started


def painted(page: Browser) -> float:
    """Seconds from the choice of a file to the first picture of its points."""
    page.wait_for("window.painted !== undefined")
    return float(page.run("return (window.painted - window.chosen) / 1000"))


def frames(page: Browser, seconds: float = 3.0) -> float:
    """Frames a second in which points are drawn, while the picture is turned by the mouse."""

    def mouse(kind: str, x: float, y: float) -> None:
        page.command("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)

    mouse("mousePressed", 300, 300)
    before, started = page.run(COUNT), perf_counter()
    while (passed := perf_counter() - started) < seconds:
        mouse("mouseMoved", 300 + 150 * math.sin(3 * passed), 300 + 80 * math.sin(2 * passed))
        sleep(0.02)
    drawn = (page.run(COUNT) - before) / (perf_counter() - started)
    mouse("mouseReleased", 300, 300)
    return float(drawn)


def memory(folder: Path) -> float:
    """PSS of the processes of pages [MB]; the largest is this page's."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            command = (process / "cmdline").read_bytes()
            if b"--type=renderer" in command and str(folder).encode() in command:
                found.append(pss(int(process.name)) / 1e6)
        except OSError:
            continue
    return max(found)


def many(figures: Report, folder: Path) -> None:
    """A million points: how soon they are seen, how they turn, what they take."""
    file = folder / "many.npy"
    file.write_bytes(npy(points("cylinder", MANY)))
    with opened(folder) as (page, url):
        page.open(url)
        page.wait_for(SETTLED)
        figures.note("memory of the empty page", memory(folder), "MB")
        times = []
        for _ in range(TURNS):
            choose(page, url, file)
            times.append(painted(page))
        figures.note("a million points are seen after", [round(each, 2) for each in times], "s")
        figures.at_most("median", sorted(times)[TURNS // 2], TO_PAINT, "s", clock=True)
        figures.note("turned while they are fitted", frames(page), "frames a second")
        page.wait_for(ANSWERED)
        figures.at_least("turned when they are fitted", frames(page), FRAMES, "frames a second", clock=True)
        sleep(2.0)
        figures.at_most("memory of the page", memory(folder), MEMORY, "MB")


def some(figures: Report, folder: Path) -> None:
    """200,000 points: how soon the answer is there, beside the fit of the same points alone."""
    cloud = points("cylinder", SOME)
    for name, write in (("npy", npy), ("csv", csv)):
        file = folder / f"some.{name}"
        file.write_bytes(write(cloud))
        added = []
        with opened(folder) as (page, url):
            for _ in range(TURNS + 1):
                started = choose(page, url, file)
                page.wait_for(ANSWERED)
                answered = perf_counter()
                primfit.fit(cloud)
                added.append(2 * answered - started - perf_counter())
        figures.note(f"200,000 points of {name}: beyond the fit", [round(each, 2) for each in added[1:]], "s")
        figures.at_most("median", sorted(added[1:])[TURNS // 2], BEYOND, "s", clock=True)


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_args()
    with reported("page") as figures, TemporaryDirectory(prefix="primfit-fire-") as name:
        many(figures, Path(name))
        some(figures, Path(name))
    sys.exit(1 if figures.missed else 0)


if __name__ == "__main__":
    main()
