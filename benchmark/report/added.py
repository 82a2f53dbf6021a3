"""The picture of what the service adds to a fit."""

from collections.abc import Sequence
from pathlib import Path

from ..service import BAR, FORMATS, SIZES, Row
from .pictures import COLORS, INK, clean, make_figure

SHADES = dict(
    zip(FORMATS, (COLORS["primfit"], COLORS["primfit-knn"], COLORS["primfit-reversed"]), strict=True)
)
WIDTH = 0.26


def draw_added(rows: Sequence[Row], path: Path) -> None:
    """The fastest requests less the fastest fits, and the limit that one of them is held to."""
    figure = make_figure(5.6, 3.4)
    axes = figure.add_subplot()
    for offset, (format, color) in enumerate(SHADES.items()):
        own = [row for row in rows if row.format == format]
        places = [SIZES.index(row.points) + (offset - 1) * WIDTH for row in own]
        axes.bar(places, [row.least for row in own], WIDTH * 0.92, color=color, label=format)
    axes.axhline(BAR[2], color=INK, linewidth=0.8, linestyle="--")
    axes.set_xticks(range(len(SIZES)), [f"{size:,} points" for size in SIZES])
    axes.set_ylabel("least added to the fit [ms]")
    axes.set_ylim(bottom=0)
    clean(axes)
    axes.legend(frameon=False)
    figure.savefig(path, metadata={"Software": None})
