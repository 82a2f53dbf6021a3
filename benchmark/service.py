"""What the service adds to a fit: requests to a real `primfit serve` and the fit alone, in turns.

Each has some in a row, as a service in use has them: after other work its code is no longer in the cache of
the processor, and so is that of the fit alone. The first of each row is not counted. The fit alone runs in a
process of its own, as niced as the workers of the service and on the same processor.
"""

import io
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from primfit.fitting.geometry.vectors import Array
from primfit.synthetic import ScannerRecipe, cloud
from primfit.synthetic.recipes import KINDS, Range

from .cases import Case
from .runner import Child
from .serving import PATIENCE, ServiceError, connect, get, on_one_processor, post, serving

METHOD = "primfit"
SIZES = (100, 3000, 10_000)
BAR = ("npy", 3000, 2.0)
"""Format and points of the request that may take at most so many milliseconds more than the fit alone."""
LIVEZ = (300_000, 100.0)
"""Points that a worker is busy with, and the milliseconds that `GET /livez` may take meanwhile."""
NICE = 5
"""What workers of the service add to their niceness."""
IN_A_ROW = 5
SCAN = ScannerRecipe(noise=Range(1e-3, 1e-3), noiseless=0.0, outliers=Range(0.0, 0.0), size=Range(1.0, 1.0))


def npy(points: Array) -> bytes:
    stream = io.BytesIO()
    np.save(stream, points)
    return stream.getvalue()


def csv(points: Array) -> bytes:
    return ("x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in points.tolist())).encode()


def as_json(points: Array) -> bytes:
    return json.dumps({"points": points.tolist()}).encode()


FORMATS: dict[str, tuple[str, Callable[[Array], bytes]]] = {
    "npy": ("application/x-npy", npy),
    "csv": ("text/csv", csv),
    "json": ("application/json", as_json),
}
"""Media type and writer of each, all at the full precision of float64."""


@dataclass(frozen=True)
class Row:
    """One format and size: milliseconds, (clouds, fits)."""

    format: str
    points: int
    n_bytes: int
    requests: Array
    fits: Array

    @property
    def added(self) -> Array:
        """What the request took more than the fit of the same cloud in the same turn."""
        return np.asarray(self.requests - self.fits)

    @property
    def least(self) -> float:
        """The fastest request less the fastest fit, a mean over the clouds: what others blur least."""
        return float(np.mean(self.requests.min(axis=1) - self.fits.min(axis=1)))


def measure(turns: int, seed: int, log: Path) -> Iterator[Row]:
    """A row for each format and size, of so many turns through a cloud of each kind.

    Raises
    ------
    ServiceError
        The service did not start, or answers otherwise than the fit alone.
    """
    with ExitStack() as opened:
        child = opened.enter_context(Child(Path(sys.executable), log))
        with on_one_processor():
            port = opened.enter_context(serving(log))
        child.introduction(METHOD)
        assert child.process is not None
        os.setpriority(os.PRIO_PROCESS, child.process.pid, os.getpriority(os.PRIO_PROCESS, 0) + NICE)
        for size in SIZES:
            cases = [_case(seed, kind, size) for kind in KINDS]
            for format in FORMATS:
                yield _row(port, child, format, cases, turns)


def _case(seed: int, kind: str, size: int) -> Case:
    """A scan of `size` points."""
    drawn = cloud(replace(SCAN, seed=seed, kinds=(kind,), points=Range(size, size)), 0)
    return Case(kind, np.ascontiguousarray(drawn.points[:size]), None, {})


def _row(port: int, child: Child, format: str, cases: list[Case], turns: int) -> Row:
    media_type, write = FORMATS[format]
    bodies = [write(case.points) for case in cases]
    requests, fits = np.zeros((2, len(cases), 1 + turns, IN_A_ROW))
    for turn in range(1 + turns):
        for place, (case, body) in enumerate(zip(cases, bodies, strict=True)):
            for i in range(IN_A_ROW):
                outcome = child.fit(METHOD, case, None, PATIENCE)
                fits[place, turn, i] = 1e3 * (outcome.seconds or 0.0)
            with connect(port) as connection:  # anew: the service ends one that waits for slow fits
                for i in range(IN_A_ROW):
                    started = time.perf_counter()
                    content = post(connection, media_type, body)
                    requests[place, turn, i] = 1e3 * (time.perf_counter() - started)
            answer = json.loads(content)
            if (answer["status"], answer["primitive"]) != (outcome.status, outcome.primitive):
                raise ServiceError(f"the service and the fit alone answer differently: {format}, {case.name}")
    counted = (values[:, 1:, 1:].reshape(len(cases), -1) for values in (requests, fits))
    return Row(format, len(cases[0].points), len(bodies[0]), *counted)


def slowest_livez(seed: int, log: Path) -> float:
    """Milliseconds of the slowest `GET /livez` while a large scan in CSV is received, read and fitted.

    Raises `ServiceError` as `measure` does.
    """
    body = csv(_case(seed, KINDS[2], LIVEZ[0]).points)
    times = []
    with ExitStack() as opened:
        port = opened.enter_context(serving(log))
        posting, asking = (opened.enter_context(connect(port)) for _ in range(2))
        answer = opened.enter_context(ThreadPoolExecutor(1)).submit(post, posting, "text/csv", body)
        while not answer.done():
            started = time.perf_counter()
            get(asking, "/livez")
            times.append(1e3 * (time.perf_counter() - started))
        answer.result()
    return max(times)


def livez_line(slowest: float) -> str:
    """The figure beside its bar."""
    n_points, limit = LIVEZ
    return (
        f"Bar: `GET /livez` takes at most {limit:g} ms while {n_points:,} points in CSV are read and fitted: "
        f"{slowest:.1f} ms, {'met' if slowest <= limit else 'missed'}."
    )


def table(rows: list[Row]) -> str:
    """The rows as a table of Markdown, and whether the bar is met."""
    lines = [
        "| points | format | body | fit alone | request | added | 5 to 95 % | least added |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        low, high = np.percentile(row.added, (5, 95))
        cells = [f"{row.points:,}", row.format, f"{row.n_bytes / 1000:.1f} kB"]
        cells += [f"{np.median(values):.2f} ms" for values in (row.fits, row.requests, row.added)]
        lines.append(f"| {' | '.join(cells)} | {low:.2f} to {high:.2f} ms | {row.least:.2f} ms |")
    format, points, limit = BAR
    added = next(np.median(row.added) for row in rows if (row.format, row.points) == (format, points))
    lines += [
        "",
        f"Bar: a request of {points:,} points as {format} takes at most {limit:g} ms more than the fit: "
        f"{added:.2f} ms, {'met' if added <= limit else 'missed'}.",
    ]
    return "\n".join(lines)


def busy() -> str:
    """A warning where others use the machine; empty where none do."""
    load, processors = os.getloadavg()[0], os.cpu_count() or 1
    if load < 0.5 * processors:
        return ""
    return (
        f"\nThe machine is busy (load {load:.1f}, {processors} processors): only the last column means much."
    )
