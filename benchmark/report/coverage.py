"""The table and the picture of `primfit bench coverage`."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from primfit.synthetic.recipes import KINDS

from ..coverage import LAWS, Outcome
from .markdown import NOTHING, percent, table
from .pictures import COLORS, FAINT, INK, require_matplotlib

NUMBERS = (
    "direction",
    "position",
    "point",
    "center",
    "apex",
    "radius",
    "half_angle",
    "major_radius",
    "minor_radius",
)
BARS = {
    "independent": (0.93, 0.97),
    "uneven": (0.93, 0.97),
    "correlated": (0.90, 0.98),
    "arcs": (0.90, 0.98),
    "correlated arcs": (0.90, 0.98),
    "along the ray": (0.92, 0.98),
    "exponential": (0.92, 0.98),
    "wavy": (0.92, 0.98),
    "bowed": (0.92, 1.0),
}
"""Between which the share of intervals that hold the truth should lie; few points have no bar."""

ROWS, LOWEST = 2, 80.0
"""Of the picture: rows of panels, and the share [%] at which what is lower is drawn."""

WITH_INTERVALS = tuple(law for law in LAWS if law != "minimal")


def write_coverage(found: Sequence[Outcome], command: str, folder: Path) -> Path:
    """Write uncertainty-coverage.md and images/uncertainty-coverage.png; returns the path of the first."""
    require_matplotlib()
    (folder / "images").mkdir(parents=True, exist_ok=True)
    path = folder / "uncertainty-coverage.md"
    path.write_text("\n".join(_lines(found, command)) + "\n", encoding="utf-8")
    _draw(found, folder / "images" / "uncertainty-coverage.png")
    return path


def _lines(found: Sequence[Outcome], command: str) -> list[str]:
    return [
        "# Coverage of the intervals",
        "",
        f"Written by `{command}`. [uncertainty.md](uncertainty.md) says what is drawn and what is counted.",
        "",
        "## How many of the 95% intervals hold the truth",
        "",
        *table(("noise", "kind", "clouds", "no_fit", *NUMBERS), _coverage_rows(found), 2),
        "",
        "Behind the stroke: root mean square error over the Cramér-Rao value, where no interval is a "
        "profile. *Clouds*: answered with intervals, of those drawn.",
        "",
        "## How often warnings appear",
        "",
        *table(("warning", "deserved", "given", "not deserved", "given"), _warning_rows(found)),
    ]


def _chosen(found: Sequence[Outcome], law: str, kind: str) -> list[Outcome]:
    return [each for each in found if (each.law, each.kind) == (law, kind)]


def _coverage_rows(found: Sequence[Outcome]) -> list[list[str]]:
    rows = []
    for law in WITH_INTERVALS:
        for kind in KINDS:
            drawn = _chosen(found, law, kind)
            if not drawn:
                continue
            seen = [each for each in drawn if each.covered]
            cells = [_cell(seen, number) for number in NUMBERS]
            refused = percent(float(np.mean([each.status == "no_fit" for each in drawn])))
            rows.append([law, kind, f"{len(seen)} of {len(drawn)}", refused, *cells])
    return rows


def _cell(seen: Sequence[Outcome], number: str) -> str:
    covered = [each.covered[number] for each in seen if number in each.covered]
    if not covered:
        return NOTHING
    squares = [each.relative[number] for each in seen if number in each.relative]
    ratio = f" / {np.sqrt(np.mean(squares)):.2f}" if squares else ""
    return percent(float(np.mean(covered))) + ratio


def _warning_rows(found: Sequence[Outcome]) -> list[list[str]]:
    codes = sorted({code for each in found for code in each.deserved})
    rows = []
    for code in codes:
        cells = [code]
        for wanted in (True, False):
            given = [code in each.given for each in found if each.deserved.get(code) is wanted]
            cells += [f"{len(given):,}", percent(float(np.mean(given))) if given else NOTHING]
        rows.append(cells)
    return rows


def _draw(found: Sequence[Outcome], path: Path) -> None:
    """A point for each kind and number, with the bars; a panel for each noise that was drawn."""
    from matplotlib.figure import Figure

    laws = [law for law in WITH_INTERVALS if any(each.law == law for each in found)]
    rows = min(ROWS, max(len(laws), 1))
    figure = Figure(figsize=(9.0, 3.2 * ROWS), dpi=120, layout="constrained")
    columns = max(-(-len(laws) // rows), 1)
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for panel in axes.flat[len(laws) :]:
        panel.set_visible(False)
    for panel, law in zip(axes.flat, laws, strict=False):
        if law in BARS:
            panel.axhspan(*(100.0 * bar for bar in BARS[law]), color=FAINT, zorder=0)
        panel.axhline(95.0, color=INK, linewidth=0.8)
        for place, kind in enumerate(KINDS):
            seen = [each for each in _chosen(found, law, kind) if each.covered]
            shares = [
                100.0 * np.mean([each.covered[number] for each in seen])
                for number in NUMBERS
                if seen and number in seen[0].covered
            ]
            panel.plot(
                [place] * len(shares), np.maximum(shares, LOWEST), "o", color=COLORS["primfit"], markersize=4
            )
        panel.set_title(law, fontsize=9)
        panel.set_xticks(range(len(KINDS)), KINDS, rotation=90, fontsize=8)
        panel.set_ylim(LOWEST - 0.5, 100.5)
    figure.supylabel("95% intervals that hold the truth [%]", fontsize=8)
    figure.savefig(path, metadata={"Software": None})
