"""Figures of a test beside their bars: printed, and kept in build/fire/ whether they hold or not.

A figure of the clock fails no test, since a busy machine makes it worse: `python -m tests.fire.report` shows
all that are kept, and its exit status is 1 where one misses its bar.
"""

import json
import os
import platform
import sys
from collections.abc import Iterator, Mapping, Sequence
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

    def note(self, what: str, value: Any, unit: str = "") -> None:
        """A figure without a bar."""
        self._add(what, value, unit, None, True)

    def at_most(self, what: str, value: float, bar: float, unit: str = "", clock: bool = False) -> None:
        self._add(what, value, unit, f"at most {bar:g}", value <= bar, clock)

    def at_least(self, what: str, value: float, bar: float, unit: str = "", clock: bool = False) -> None:
        self._add(what, value, unit, f"at least {bar:g}", value >= bar, clock)

    def equals(self, what: str, value: float, wanted: float) -> None:
        self._add(what, value, "", f"{wanted:g}", value == wanted)

    def none(self, what: str, found: Sequence[object]) -> None:
        """What should not be there; the first few are shown."""
        shown = len(found) if len(found) == 0 else f"{len(found)}: {', '.join(map(str, found[:SHOWN]))}"
        self._add(what, shown, "", "none", not found)

    def _add(
        self, what: str, value: Any, unit: str, bar: str | None, held: bool, clock: bool = False
    ) -> None:
        value = round(value, 4) if isinstance(value, float) else value
        figure = {"figure": what, "value": value, "unit": unit, "bar": bar, "held": held, "clock": clock}
        self.figures.append(figure)

    @property
    def missed(self) -> list[dict[str, Any]]:
        """The figures that miss their bars."""
        return [figure for figure in self.figures if not figure["held"]]

    def text(self) -> str:
        return "\n".join([f"{self.name}:", *(f"  {_told(figure)}" for figure in self.figures)])

    def write(self) -> None:
        """To build/fire/NAME.json, with the machine and the moment."""
        FOLDER.mkdir(parents=True, exist_ok=True)
        where = {"machine": machine(), "at": datetime.now(UTC).isoformat(timespec="seconds")}
        content = {"name": self.name, **where, "figures": self.figures}
        (FOLDER / f"{self.name}.json").write_text(json.dumps(content, indent=1) + "\n")


@contextmanager
def reported(name: str) -> Iterator[Report]:
    """A report that is printed and written in the end; then figures may fail the test, not the clock's."""
    report = Report(name)
    try:
        yield report
    finally:
        report.write()
        print(f"\n{report.text()}", flush=True)
    failed = [_told(figure) for figure in report.missed if not figure["clock"]]
    assert not failed, "; ".join(failed)


def _told(figure: Mapping[str, Any]) -> str:
    bar = f" (bar: {figure['bar']}: {'held' if figure['held'] else 'MISSED'})" if figure["bar"] else ""
    return f"{figure['figure']}: {figure['value']} {figure['unit']}".rstrip() + bar


def machine() -> str:
    """The processor, and how many of them this process may use."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.processor()}, {len(os.sched_getaffinity(0))} processors"


def main() -> None:
    """Show all reports that are kept, and fail where a bar is missed."""
    n_missed = 0
    for file in sorted(FOLDER.glob("*.json")):
        kept = json.loads(file.read_text())
        report = Report(f"{kept['name']}, {kept['at']}, {kept['machine']}")
        report.figures = kept["figures"]
        n_missed += len(report.missed)
        print(report.text())
    sys.exit(f"{n_missed} figures miss their bars" if n_missed else 0)


if __name__ == "__main__":
    main()
