"""The picture of what the service adds to a fit."""

from collections.abc import Sequence
from pathlib import Path

from ..service import BAR, BODIES, LARGE, Row
from .pictures import COLORS, INK, clean, make_figure

SHADES = dict(
    zip(
        BODIES,
        (COLORS[name] for name in ("primfit", "primfit-knn", "primfit-reversed", "primfit-none")),
        strict=True,
    )
)
WIDTH = 0.2


def draw_added(rows: Sequence[Row], path: Path) -> None:
    """The fastest requests less the fastest fits, and the limit that one of them is held to.

    Large clouds, whose bodies take a hundred times as long to read, are left to the table.
    """
    sizes = sorted({row.points for row in rows if row.points < LARGE})
    figure = make_figure(5.6, 3.4)
    axes = figure.add_subplot()
    for offset, (format, color) in enumerate(SHADES.items()):
        own = [row for row in rows if row.format == format and row.points in sizes]
        places = [sizes.index(row.points) + (offset - 1.5) * WIDTH for row in own]
        axes.bar(places, [row.least for row in own], WIDTH * 0.92, color=color, label=format)
    axes.axhline(BAR[2], color=INK, linewidth=0.8, linestyle="--")
    axes.set_xticks(range(len(sizes)), [f"{size:,} points" for size in sizes])
    axes.set_ylabel("least added to the fit [ms]")
    axes.set_ylim(bottom=0)
    clean(axes)
    axes.legend(frameon=False)
    figure.savefig(path, metadata={"Software": None})
