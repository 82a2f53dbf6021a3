"""`primfit bench steps`: processor time of each step of an answer, its floor, and figures kept before."""

import gc
import io
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from primfit.fitting.geometry.vectors import Array
from primfit.synthetic.recipes import KINDS

from ..cases import CASE_SETS, Case
from ..child import processor
from ..sources import ROOT
from . import asked
from .ceilings import Ceilings, calibration
from .floor import FLOORS, GUESSES, Facts
from .table import MODULES, REST, STEPS
from .timers import Clock, check_entered, timers

FAMILIES = {"shrec": "clouds as in SHREC 2022", "scanner": "scans"}
"""Sets that clouds are taken from, and what they are called."""
POINTS = 2750
"""Points of the median cloud of the benchmark; the clouds nearest to it are taken."""
DRAWN = 30
"""Clouds of each set that are looked at for those."""
REPEATS = 3
"""Times that an answer is timed, once warm; the fastest counts, which others disturbed least."""
WHOLE = "whole"
SLOWER = 1.25
"""A step is slower where its time, in calibration loops, is more than this times what was kept ..."""
SEEN = 0.02
"""... and the difference more than this share of the whole answer."""
MOST = 1000
"""Times over the floor that are told apart."""
KEPT = ROOT / "benchmark" / "speed" / "kept.json"


@dataclass(frozen=True)
class Timed:
    """One cloud: its true kind and points, milliseconds by step and `WHOLE`, and those of the floors."""

    kind: str
    points: int
    tried: int
    spent: Mapping[str, float]
    floor: Mapping[str, float]


@dataclass(frozen=True)
class Family:
    """Clouds of one set; all figures are means over the kinds of medians over the clouds of a kind."""

    name: str
    clouds: Sequence[Timed]

    def _mean(self, values: Sequence[float]) -> float:
        by_kind: dict[str, list[float]] = {}
        for cloud, value in zip(self.clouds, values, strict=True):
            by_kind.setdefault(cloud.kind, []).append(value)
        return float(np.mean([np.median(each) for each in by_kind.values()]))

    def spent(self, step: str) -> float:
        return self._mean([cloud.spent.get(step, 0.0) for cloud in self.clouds])

    def floor(self, step: str) -> float:
        return self._mean([cloud.floor.get(step, 0.0) for cloud in self.clouds])

    @property
    def points(self) -> float:
        return float(np.median([cloud.points for cloud in self.clouds]))

    @property
    def tried(self) -> float:
        return float(np.mean([cloud.tried for cloud in self.clouds]))


@dataclass(frozen=True)
class Measured:
    """A run: what the machine is and can do, and the families; `loop` is the calibration in milliseconds."""

    machine: str
    loop: float
    ceilings: Ceilings
    families: Sequence[Family]


def measure(a_kind: int, seed: int) -> Measured:
    """So many clouds of each kind in each family.

    Raises
    ------
    NameGoneError : the table of steps does not fit the code
    """
    for module in MODULES:
        import_module(module)
    gc.freeze()  # what is imported by now need not be looked through before each fit
    best, clock = Ceilings.measured(), Clock()
    loops: list[float] = []
    families = []
    for name in FAMILIES:
        clouds = []
        for case in chosen(name, a_kind, seed):
            loops.append(1e3 * calibration())
            clouds.append(timed(case, best, clock))
        families.append(Family(name, clouds))
    check_entered(clock, STEPS)
    return Measured(processor(), float(np.median(loops)), best, families)


def chosen(name: str, a_kind: int, seed: int) -> Iterator[Case]:
    """Of each kind the clouds, among the first of a set, with numbers of points nearest to `POINTS`."""
    drawn = [CASE_SETS[name].draw(seed, index) for index in range(max(DRAWN, a_kind * len(KINDS)))]
    for kind in KINDS:
        own = [case for case in drawn if case.kind == kind]
        yield from sorted(own, key=lambda case: abs(np.log(len(case.points) / POINTS)))[:a_kind]


def timed(case: Case, best: Ceilings, clock: Clock) -> Timed:
    """One cloud: fitted once to be warm, then without timers, then with them."""
    body = npy(case.points)
    answer = asked.written(body)
    whole = min(_alone(body) for _ in range(REPEATS))
    found = min((_by_step(body, clock) for _ in range(REPEATS)), key=lambda spent: sum(spent.values()))
    facts = facts_of(len(case.points), answer, clock.entries)
    spent = {name: 1e3 * seconds for name, seconds in found.items()} | {WHOLE: 1e3 * whole}
    floor = {name: 1e3 * work(facts).seconds(best) for name, work in FLOORS.items()}
    floor[WHOLE] = sum(floor.values())
    return Timed(case.kind, len(case.points), len(facts.tried), spent, floor)


def npy(points: Array) -> bytes:
    stream = io.BytesIO()
    np.save(stream, points)
    return stream.getvalue()


def facts_of(points: int, answer: bytes, entries: Mapping[str, int]) -> Facts:
    """What the floor depends on, as an answer of `POST /fit` tells it, and how often steps were entered."""
    told: Mapping[str, Any] = json.loads(answer)
    tried = tuple(_counted(each["kind"]) for each in told["attempts"] if each["primitive"] is not None)
    surfaces = [told["primitive"], *(other for other in told["alternatives"])]
    answered = tuple(_counted(surface["kind"]) for surface in surfaces if surface is not None)
    exact = told["noise"] is not None and told["noise"]["exact_share"] > 0.0
    return Facts(
        points, tried, answered, exact, not entries.get("starts"), entries.get("rivals", 0), len(answer)
    )


def _counted(kind: str) -> str:
    """The kind, or the dearest one in place of one that the floor has no counts of."""
    return kind if kind in GUESSES else "torus"


def _alone(body: bytes) -> float:
    """Seconds of the processor without timers."""
    gc.collect()
    started = time.process_time_ns()
    asked.written(body)
    return 1e-9 * (time.process_time_ns() - started)


def _by_step(body: bytes, clock: Clock) -> dict[str, float]:
    """Seconds of the processor by step, and of what is between them."""
    clock.reset()
    gc.collect()
    with timers(clock, STEPS), clock.step(REST):
        asked.written(body)
    return clock.seconds


# -- figures that are kept ----------------------------------------------------------------------------------


def ratios(measured: Measured) -> dict[str, dict[str, float]]:
    """By family and step, in calibration loops."""
    return {
        family.name: {step: family.spent(step) / measured.loop for step in (*STEPS, REST, WHOLE)}
        for family in measured.families
    }


def keep(measured: Measured, path: Path = KEPT) -> None:
    """Write what later runs are compared with."""
    rounded = {
        family: {step: float(f"{value:.4g}") for step, value in steps.items()}
        for family, steps in ratios(measured).items()
    }
    held = {"machine": measured.machine, "loop_ms": round(measured.loop, 3), "loops": rounded}
    path.write_text(json.dumps(held, indent=2) + "\n")


def slower(measured: Measured, path: Path = KEPT) -> list[str]:
    """A line for each step that takes more loops than what was kept allows; a new step is not held to any."""
    kept, found = json.loads(path.read_text())["loops"], []
    for family, steps in ratios(measured).items():
        before = kept.get(family, {})
        for step, now in steps.items():
            was = before.get(step)
            if was is not None and now > SLOWER * was and now - was > SEEN * before[WHOLE]:
                found.append(
                    f"{family}, {step}: {now / was:.2f} times what was kept "
                    f"({now:.3g} calibration loops, not {was:.3g})"
                )
    return found


# -- the section of docs/performance.md ---------------------------------------------------------------------


def section(measured: Measured) -> str:
    """Ceilings, and a table for each family."""
    parts = [_ceilings_line(measured)]
    parts += [_table(family) for family in measured.families]
    return "\n\n".join(parts)


def _ceilings_line(measured: Measured) -> str:
    best = {name: value / 1e9 for name, value in asdict(measured.ceilings).items()}
    return (
        f"Machine: {measured.machine}, one thread. Ceilings, measured in the same run: {best['flops']:.1f} "
        f"billion additions and multiplications a second, {best['roots']:.2f} billion roots or divisions, "
        f"{best['logs']:.2f} billion logarithms, {best['compares']:.2f} billion compares of a sort, "
        f"{best['bytes']:.1f} GB/s copied, {best['hashed']:.2f} GB/s hashed; a call of a Python function "
        f"takes {1.0 / best['calls']:.0f} ns, of a NumPy function on three numbers "
        f"{1.0 / best['numpy_calls']:.0f} ns. The calibration loop takes {measured.loop:.2f} ms."
    )


def _over(spent: float, floor: float) -> str:
    """How many times the floor; where that is next to nothing no number is worth showing."""
    return f"{spent / floor:,.1f}" if spent < MOST * floor else f"over {MOST:,}"


def _table(family: Family) -> str:
    whole = family.spent(WHOLE)
    called = FAMILIES[family.name]
    lines = [
        f"**{called[0].upper()}{called[1:]}**: {len(family.clouds)} clouds, as many of each kind, "
        f"median {family.points:,.0f} points, {family.tried:.1f} kinds tried on the average.",
        "",
        "| step | time | share | floor | time over floor |",
        "|---|---|---|---|---|",
    ]
    for step in (*STEPS, REST):
        spent, floor = family.spent(step), family.floor(step)
        against = f"{1e3 * floor:,.0f} µs | {_over(spent, floor)}" if floor else "– | –"
        lines.append(f"| {step} | {spent:.3f} ms | {spent / whole:.0%} | {against} |")
    floor = family.floor(WHOLE)
    lines.append(
        f"| **whole answer** | **{whole:.2f} ms** | | {1e3 * floor:,.0f} µs | {whole / floor:,.1f} |"
    )
    timed = sum(family.spent(step) for step in (*STEPS, REST))
    lines += ["", f"The medians of the steps add up to {timed:.2f} ms; the whole was timed without timers."]
    return "\n".join(lines)
