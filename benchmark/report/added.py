"""The picture of what the service adds to a fit."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmark.report.pictures import COLORS, INK, clean, make_figure
from benchmark.service import BAR, FORMATS, SIZES, Row

SHADES = dict(
    zip(FORMATS, (COLORS["primfit"], COLORS["primfit-knn"], COLORS["primfit-reversed"]), strict=True)
)
WIDTH = 0.26


def draw_added(rows: Sequence[Row], path: Path) -> None:
    """Bars of the medians with the 5 to 95 % of the turns, and the bar that one of them is held to."""
    figure = make_figure(5.6, 3.4)
    axes = figure.add_subplot()
    for offset, (format, color) in enumerate(SHADES.items()):
        own = [row for row in rows if row.format == format]
        places = [SIZES.index(row.points) + (offset - 1) * WIDTH for row in own]
        axes.bar(places, [np.median(row.added) for row in own], WIDTH * 0.92, color=color, label=format)
        for place, row in zip(places, own, strict=True):
            low, high = np.percentile(row.added, (5, 95))
            axes.plot([place, place], [low, high], color=INK, linewidth=0.8)
    axes.axhline(BAR[2], color=INK, linewidth=0.8, linestyle="--")
    axes.set_xticks(range(len(SIZES)), [f"{size:,} points" for size in SIZES])
    axes.set_ylabel("added to the fit [ms]")
    axes.set_ylim(bottom=0)
    clean(axes)
    axes.legend(frameon=False)
    figure.savefig(path, metadata={"Software": None})
