"""The histogram of the residuals, in the colours that they have in the other pictures."""

import numpy as np

from primfit.fitting.answer.residuals import Deviations

from .markup import Markup, element, joined
from .svg import colored, picture, text, ticks

WIDTH, HEIGHT = 10000, 3600
LEFT, RIGHT, TOP, BOTTOM = 900, 200, 300, 560

MARKED = (5.0, 50.0, 95.0)
"""Percentiles with a line."""


def histogram(deviations: Deviations, limit: float, unit: str) -> Markup:
    """Bars of the counts, with lines at some percentiles."""
    edges, counts = deviations.histogram.edges, deviations.histogram.counts
    right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM
    scale = (right - LEFT) / (edges[-1] - edges[0])
    x = LEFT + (edges - edges[0]) * scale
    top = bottom - counts / counts.max() * (bottom - TOP - 200)
    level, colors = colored((edges[:-1] + edges[1:]) / 2.0, limit)
    bars = joined(
        element(
            "rect",
            x=round(x[i]),
            y=round(top[i]),
            width=round(x[i + 1]) - round(x[i]) - 12,
            height=bottom - round(top[i]),
            fill=colors[level[i]],
            class_="bar",
        )
        for i in np.flatnonzero(counts)
    )
    return picture(
        WIDTH,
        HEIGHT,
        bars,
        _across(edges, scale, bottom, unit),
        _upwards(int(counts.max()), bottom),
        _marks(deviations, edges[0], scale, bottom),
        title="histogram of the residuals",
    )


def _across(edges: np.ndarray, scale: float, bottom: int, unit: str) -> Markup:
    parts = [element("path", d=f"M{LEFT} {bottom}H{WIDTH - RIGHT}", class_="line")]
    for value in ticks(edges[0], edges[-1], 9):
        x = round(LEFT + (value - edges[0]) * scale)
        parts.append(element("path", d=f"M{x} {bottom}v50", class_="line"))
        parts.append(text(x, bottom + 210, f"{value:.6g}", "middle"))
    middle = (LEFT + WIDTH - RIGHT) / 2.0
    return joined([*parts, text(middle, bottom + 430, f"signed residual [{unit}]", "middle", class_="name")])


def _upwards(most: int, bottom: int) -> Markup:
    parts = []
    for value in ticks(0.0, most, 4):
        if value != round(value):
            continue
        y = round(bottom - value / most * (bottom - TOP - 200))
        parts.append(element("path", d=f"M{LEFT} {y}h-50", class_="line"))
        parts.append(text(LEFT - 90, y + 50, f"{value:,.0f}", "end"))
    x, y = LEFT - 720, (TOP + bottom) // 2
    name = text(x, y, "points", "middle", class_="name", transform=f"rotate(-90 {x} {y})")
    return joined([*parts, name])


def _marks(deviations: Deviations, first: float, scale: float, bottom: int) -> Markup:
    parts = []
    for percent in MARKED:
        x = round(LEFT + (deviations.percentiles[percent] - first) * scale)
        anchor = "end" if percent < 50.0 else "start" if percent > 50.0 else "middle"
        label = "median" if percent == 50.0 else f"{percent:g} %"
        y = TOP - 120 if percent == 50.0 else TOP + 60
        parts.append(element("path", d=f"M{x} {y + 40}V{bottom}", class_="mark"))
        parts.append(text(x, y, label, anchor))
    return joined(parts)
