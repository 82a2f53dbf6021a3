"""What the service adds to a fit: requests to a real `primfit serve` and the fit alone, in turns.

Each has some in a row, as a service in use has them: after other work its code is no longer in the cache of
the processor, and so is that of the fit alone. The first of each row is not counted. The fit alone runs in a
process of its own, as niced as the workers of the service and on the same processor. Requests come from a
bare socket, and from a plain client of the standard library on one connection that is kept open.
"""

import base64
import io
import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
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
from .serving import (
    CLIENTS,
    PATIENCE,
    Service,
    ServiceError,
    connect,
    get,
    on_one_processor,
    post,
    serving,
)

METHOD = "primfit"
SIZES = (100, 1000, 3000, 10_000, 100_000, 1_000_000)
LARGE = 100_000
"""From so many points on a fit takes long: one turn, none before it to warm up, and two in a row."""
BAR = ("npy", 3000, 2.0)
"""Format and points of the request that may take at most so many milliseconds more than the fit alone."""
LIVEZ = (300_000, 100.0)
"""Points that a worker is busy with, and the milliseconds that `GET /livez` may take meanwhile."""
NICE = 5
"""What workers of the service add to their niceness."""
IN_A_ROW = 5
SCAN = ScannerRecipe(noise=Range(1e-3, 1e-3), noiseless=0.0, outliers=Range(0.0, 0.0), size=Range(1.0, 1.0))
LIMITS = {"PRIMFIT_MAX_JSON_POINTS": str(max(SIZES)), "PRIMFIT_MAX_BODY_BYTES": str(2**28)}
"""Settings of the service that let the largest bodies in."""


def npy(points: Array) -> bytes:
    stream = io.BytesIO()
    np.save(stream, points)
    return stream.getvalue()


def csv(points: Array) -> bytes:
    return ("x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in points.tolist())).encode()


def as_json(points: Array) -> bytes:
    return json.dumps({"points": points.tolist()}).encode()


def as_base64(points: Array) -> bytes:
    text = base64.b64encode(points.astype("<f8").tobytes()).decode()
    return json.dumps({"points": {"dtype": "float64", "shape": points.shape, "base64": text}}).encode()


FORMATS: dict[str, tuple[str, Callable[[Array], bytes]]] = {
    "npy": ("application/x-npy", npy),
    "csv": ("text/csv", csv),
    "json": ("application/json", as_json),
}
"""Media type and writer of each, all at the full precision of float64."""
BODIES = FORMATS | {"base64": ("application/json", as_base64)}
"""The same with the array of JSON that is written as its bytes."""


@dataclass(frozen=True)
class Times:
    """Milliseconds: `wall` (clouds, fits); of the processor, a mean of each row, `cpu` (clouds, turns)."""

    wall: Array
    cpu: Array

    def beyond(self, fits: "Times") -> "Times":
        """What these took more than the fits of the same cloud at the same place in the same turn."""
        return Times(self.wall - fits.wall, self.cpu - fits.cpu)


@dataclass(frozen=True)
class Row:
    """One format and size: the fits alone, and the requests of each client."""

    format: str
    points: int
    n_bytes: int
    fits: Times
    requests: Mapping[str, Times]

    def added(self, client: str = next(iter(CLIENTS))) -> Times:
        return self.requests[client].beyond(self.fits)

    @property
    def least(self) -> float:
        """The fastest request less the fastest fit, a mean over the clouds: what others blur least."""
        fastest = self.requests[next(iter(CLIENTS))].wall.min(axis=1)
        return float(np.mean(fastest - self.fits.wall.min(axis=1)))


def measure(
    turns: int, seed: int, log: Path, sizes: Sequence[int] = SIZES, formats: Sequence[str] = tuple(BODIES)
) -> Iterator[Row]:
    """A row for each format and size, of so many turns through a cloud of each kind.

    Raises
    ------
    ServiceError
        The service did not start, or answers otherwise than the fit alone.
    """
    with ExitStack() as opened:
        child = opened.enter_context(Child(Path(sys.executable), log))
        with on_one_processor():
            service = opened.enter_context(serving(log, settings=LIMITS))
        child.introduction(METHOD)
        assert child.process is not None
        os.setpriority(os.PRIO_PROCESS, child.process.pid, os.getpriority(os.PRIO_PROCESS, 0) + NICE)
        for size in sizes:
            cases = [scan(seed, kind, size) for kind in KINDS]
            for format in formats:
                yield _row(service, child, format, cases, turns)


def scan(seed: int, kind: str, size: int) -> Case:
    """A scan of `size` points."""
    drawn = cloud(replace(SCAN, seed=seed, kinds=(kind,), points=Range(size, size)), 0)
    return Case(kind, np.ascontiguousarray(drawn.points[:size]), None, {})


def _row(service: Service, child: Child, format: str, cases: list[Case], turns: int) -> Row:
    media_type, write = BODIES[format]
    n_points = len(cases[0].points)
    turns, warming, in_a_row = (1, 0, 2) if n_points >= LARGE else (turns, 1, IN_A_ROW)
    bodies = [write(case.points) for case in cases]
    names = ("alone", *CLIENTS)
    wall = {name: np.zeros((len(cases), warming + turns, in_a_row - 1)) for name in names}
    cpu = {name: np.zeros((len(cases), warming + turns)) for name in names}
    for turn in range(warming + turns):
        for place, (case, body) in enumerate(zip(cases, bodies, strict=True)):
            here = (place, turn)
            answer, wall["alone"][here], cpu["alone"][here] = _fits(child, case, in_a_row)
            for client in CLIENTS:
                found, wall[client][here], cpu[client][here] = _requests(
                    service, client, media_type, body, in_a_row
                )
                if found != answer:
                    raise ServiceError(
                        f"the service and the fit alone answer differently: {format}, {case.name}"
                    )
    times = {
        name: Times(wall[name][:, warming:].reshape(len(cases), -1), cpu[name][:, warming:]) for name in names
    }
    fits = times.pop("alone")
    return Row(format, n_points, len(bodies[0]), fits, times)


def _fits(child: Child, case: Case, in_a_row: int) -> tuple[object, Array, float]:
    """The answer alone; milliseconds of all but the first, and the mean of those of the processor."""
    outcomes = [child.fit(METHOD, case, None, PATIENCE) for _ in range(in_a_row)]
    spent = np.array([(outcome.seconds or 0.0, outcome.cpu_seconds or 0.0) for outcome in outcomes[1:]])
    return (outcomes[0].status, outcomes[0].primitive), 1e3 * spent[:, 0], 1e3 * float(spent[:, 1].mean())


def _requests(
    service: Service, client: str, media_type: str, body: bytes, in_a_row: int
) -> tuple[object, Array, float]:
    """The same of requests; the time of the processor is that of all processes of the service."""
    wall = np.zeros(in_a_row)
    with CLIENTS[client](service.port) as ask:  # anew: the service ends one that waits for slow fits
        for place in range(in_a_row):
            if place == 1:
                busy_before = service.cpu_seconds()
            started = time.perf_counter()
            content = ask(media_type, body)
            wall[place] = time.perf_counter() - started
        busy = service.cpu_seconds() - busy_before
    answer = json.loads(content)
    return (answer["status"], answer["primitive"]), 1e3 * wall[1:], 1e3 * busy / (in_a_row - 1)


def slowest_livez(seed: int, log: Path) -> float:
    """Milliseconds of the slowest `GET /livez` while a large scan in CSV is received, read and fitted.

    Raises `ServiceError` as `measure` does.
    """
    body = csv(scan(seed, KINDS[2], LIVEZ[0]).points)
    times = []
    with ExitStack() as opened:
        service = opened.enter_context(serving(log))
        posting, asking = (opened.enter_context(connect(service.port)) for _ in range(2))
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


def table(rows: Sequence[Row]) -> str:
    """The rows as a table of Markdown, and whether the bar is met where it was measured."""
    bare, *others = CLIENTS
    names = ["points", "format", "body", "fit alone", "request", "added", "5 to 95%", "least added"]
    names += [f"added, {client}" for client in others] + ["added of the processor"]
    lines = [f"| {' | '.join(names)} |", "|" + "---|" * len(names)]
    for row in rows:
        added = row.added()
        low, high = np.percentile(added.wall, (5, 95))
        cells = [f"{row.points:,}", row.format, f"{row.n_bytes / 1000:.1f} kB"]
        cells += [f"{np.median(times.wall):.2f} ms" for times in (row.fits, row.requests[bare], added)]
        cells += [f"{low:.2f} to {high:.2f} ms", f"{row.least:.2f} ms"]
        cells += [f"{np.median(row.added(client).wall):.2f} ms" for client in others]
        known = np.isfinite(added.cpu).all()
        cells.append(f"{np.median(added.cpu):.2f} ms" if known else "–")
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join([*lines, *_bar_lines(rows)])


def _bar_lines(rows: Sequence[Row]) -> list[str]:
    format, points, limit = BAR
    held = [row for row in rows if (row.format, row.points) == (format, points)]
    if not held:
        return []
    added = np.median(held[0].added().wall)
    return [
        "",
        f"Bar: a request of {points:,} points as {format} takes at most {limit:g} ms more than the fit: "
        f"{added:.2f} ms, {'met' if added <= limit else 'missed'}.",
    ]


def busy(what: str = "only the columns of the least and of the processor mean much") -> str:
    """A warning where others use the machine; empty where none do."""
    load, processors = os.getloadavg()[0], os.cpu_count() or 1
    if load < 0.5 * processors:
        return ""
    return f"\nThe machine is busy (load {load:.1f}, {processors} processors): {what}."
