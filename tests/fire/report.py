"""Figures of a test beside their bars: printed, and kept in build/fire/ whether they hold or not."""

import json
import os
import platform
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tests.paths import ROOT

FOLDER = ROOT / "build" / "fire"
SHOWN = 5


class Report:
    """What was measured, and which of it misses its bar."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.figures: list[dict[str, Any]] = []
        self.missed: list[str] = []

    def note(self, what: str, value: Any, unit: str = "") -> None:
        """A figure without a bar."""
        self._add(what, value, unit, None, True)

    def at_most(self, what: str, value: float, bar: float, unit: str = "") -> None:
        self._add(what, value, unit, f"at most {bar:g}", value <= bar)

    def at_least(self, what: str, value: float, bar: float, unit: str = "") -> None:
        self._add(what, value, unit, f"at least {bar:g}", value >= bar)

    def equals(self, what: str, value: float, wanted: float) -> None:
        self._add(what, value, "", f"{wanted:g}", value == wanted)

    def none(self, what: str, found: Sequence[object]) -> None:
        """What should not be there; the first few are shown."""
        shown = len(found) if len(found) == 0 else f"{len(found)}: {', '.join(map(str, found[:SHOWN]))}"
        self._add(what, shown, "", "none", not found)

    def _add(self, what: str, value: Any, unit: str, bar: str | None, held: bool) -> None:
        value = round(value, 4) if isinstance(value, float) else value
        self.figures.append({"figure": what, "value": value, "unit": unit, "bar": bar, "held": held})
        if not held:
            self.missed.append(f"{what}: {value} {unit}; the bar is {bar}")

    def text(self) -> str:
        lines = [f"{self.name}:"]
        for found in self.figures:
            bar = f" (bar: {found['bar']}: {'held' if found['held'] else 'MISSED'})" if found["bar"] else ""
            lines.append(f"  {found['figure']}: {found['value']} {found['unit']}".rstrip() + bar)
        return "\n".join(lines)

    def write(self) -> None:
        """To build/fire/NAME.json, with the machine and the moment."""
        FOLDER.mkdir(parents=True, exist_ok=True)
        where = {"machine": machine(), "at": datetime.now(UTC).isoformat(timespec="seconds")}
        content = {"name": self.name, **where, "figures": self.figures}
        (FOLDER / f"{self.name}.json").write_text(json.dumps(content, indent=1) + "\n")


@contextmanager
def reported(name: str) -> Iterator[Report]:
    """A report that is printed and written in the end; then figures that miss their bars fail the test."""
    report = Report(name)
    try:
        yield report
    finally:
        report.write()
        print(f"\n{report.text()}", flush=True)
    assert not report.missed, "; ".join(report.missed)


def machine() -> str:
    """The processor, and how many of them this process may use."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.processor()}, {len(os.sched_getaffinity(0))} processors"
