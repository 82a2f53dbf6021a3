"""The histogram of the residuals, in the colors that they have in the other pictures."""

import numpy as np

from primfit.fitting.answer.residuals import BINS
from primfit.fitting.geometry.vectors import Array

from .markup import Markup, element, joined
from .numbers import Unit, count
from .ranges import robust_range
from .svg import Axis, colored, picture, text

WIDTH, HEIGHT = 6000, 4200
LEFT, RIGHT, TOP, BOTTOM = 1000, 350, 560, 700
HEADROOM = 100

MARKED = {5.0: "end", 50.0: "middle", 95.0: "start"}
"""Percentiles with a line, and the side of it that their name stands on."""


def histogram(distance: Array, limit: float, unit: str | None) -> Markup:
    """Bars of the counts of distances (N,), with lines at some percentiles.

    Distances far from the others are beyond the scale: they are counted below it.
    """
    largest = float(np.abs(robust_range(distance)).max())
    edges = np.linspace(-largest, largest, BINS + 1)
    # Those at the very ends are counted, whatever the rounding of the edges.
    edges[[0, -1]] *= 1.0 + 1e-12
    counts = np.histogram(distance, edges)[0]
    right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM
    x = np.linspace(LEFT, right, BINS + 1)
    top = bottom - counts / counts.max() * (bottom - TOP - HEADROOM)
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
    hidden = len(distance) - int(counts.sum())
    return picture(
        WIDTH,
        HEIGHT,
        bars,
        _across(largest, bottom, unit, hidden),
        _upwards(int(counts.max()), bottom),
        _marks(distance, largest, bottom),
        title="histogram of the residuals",
    )


def _across(largest: float, bottom: int, unit: str | None, hidden: int) -> Markup:
    parts = [element("path", d=f"M{LEFT} {bottom}H{WIDTH - RIGHT}", class_="line")]
    of = Unit.of(largest, unit)
    middle, half = (LEFT + WIDTH - RIGHT) / 2.0, (WIDTH - RIGHT - LEFT) / 2.0
    reach = largest * of.factor
    axis = Axis.of(-reach, reach, 2.0 * half)
    for value, label in zip(axis.values, axis.labels, strict=True):
        x = round(middle + value / reach * half)
        parts.append(element("path", d=f"M{x} {bottom}v50", class_="line"))
        parts.append(text(x, bottom + 240, label, "middle"))
    parts.append(text(middle, bottom + 500, axis.named("signed residual", of.name), "middle", class_="name"))
    if hidden:
        parts.append(text(WIDTH - RIGHT, 180, f"{count(hidden, 'point')} beyond the scale", "end"))
    return joined(parts)


def _upwards(most: int, bottom: int) -> Markup:
    parts = []
    room = bottom - TOP - HEADROOM
    axis = Axis.of(0.0, float(most), room, is_upright=True)
    for value in axis.values:
        if value != round(value):
            continue
        y = round(bottom - value / most * room)
        parts.append(element("path", d=f"M{LEFT} {y}h-50", class_="line"))
        parts.append(text(LEFT - 90, y + 60, f"{value:,.0f}", "end"))
    x, y = 180, (TOP + bottom) // 2
    name = text(x, y, "points", "middle", class_="name", transform=f"rotate(-90 {x} {y})")
    return joined([*parts, name])


def _marks(distance: Array, largest: float, bottom: int) -> Markup:
    """Lines at the percentiles; one beyond the scale is not drawn."""
    parts = []
    middle, half = (LEFT + WIDTH - RIGHT) / 2.0, (WIDTH - RIGHT - LEFT) / 2.0
    for (percent, anchor), value in zip(MARKED.items(), np.percentile(distance, list(MARKED)), strict=True):
        if abs(value) > largest:
            continue
        x = round(middle + value / largest * half)
        label = "median" if percent == 50.0 else f"{percent:g}%"
        y = TOP - 180 if percent == 50.0 else TOP + 20
        parts.append(element("path", d=f"M{x} {y + 40}V{bottom}", class_="mark"))
        parts.append(text(x, y, label, anchor))
    return joined(parts)
