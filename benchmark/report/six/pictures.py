"""The pictures of the paper's figures 8 to 10, drawn from our records."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from primfit.synthetic.perturb import TYPES, Perturbation
from primfit.synthetic.recipes import KINDS

from ...real import REAL
from ...records import Record
from ...scores import ANSWERS, averages, confusion, grouped
from .. import paper
from ..data import Data, of_the_paper
from ..pictures import Picture, clean, heatmap, make_figure
from .tables import BESIDE, shown

COLUMNS = 4
COLORS = (
    "#3b3f45",
    "#1f77b4",
    "#d1495b",
    "#e08e2b",
    "#4f9d69",
    "#7fb3da",
    "#ecaab3",
    "#00565b",
    "#7d5ba6",
    "#b8a05a",
)
"""Of A0 to A9."""
LEAST = 1e-5
"""Where the axis of mean errors begins ..."""
STUB = 1.3 * LEAST
"""... and how far the bars of smaller ones reach, so that they are seen."""
WORDS = {
    "uniform": "uniform noise",
    "gaussian": "Gaussian noise",
    "undersampling": "undersampling",
    "missing_part": "missing part",
}


def confusions(set_: str) -> Picture:
    """What draws figure 8 of a set: counts, a matrix for each method."""

    def picture(data: Data) -> Any:
        found = shown(data, set_)
        if not of_the_paper(found):
            return None
        counts = {method: confusion(records) for method, records in found.items()}
        used = np.any(list(counts.values()), axis=(0, 1)) | (np.arange(len(ANSWERS)) < len(KINDS))
        columns = min(COLUMNS, len(counts))
        rows = -(-len(counts) // columns)
        figure = make_figure(3.3 * columns + 0.4, 2.9 * rows)
        for place, (method, matrix) in enumerate(counts.items()):
            _matrix(
                figure.add_subplot(rows, columns, place + 1), method, matrix[:, used], used, place % columns
            )
        return figure

    return picture


def _matrix(axes: Any, method: str, counts: Any, used: Any, column: int) -> None:
    shares = 100 * counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    texts = [[str(number or "") for number in row] for row in counts.tolist()]
    answers = [name.replace("_", " ") for name, use in zip(ANSWERS, used, strict=True) if use]
    heatmap(axes, shares, texts, KINDS, answers, good=np.eye(*counts.shape) > 0)
    axes.set_title(method, fontsize=9.5, loc="left")
    if column == 0:
        axes.set_ylabel("truth", fontsize=8.5)


def rate_bars(data: Data) -> Any:
    """Figure 9: macro averages of the five rates."""
    return _bars(data, {rate: _macro(rate) for rate in paper.CLASSIFICATION}, _share_axis)


def error_bars(data: Data) -> Any:
    """Figure 10: mean errors of the right answers, on a logarithmic axis."""
    titles = {"l2": "L2", "mfe_sampled": "MFE", "hausdorff_sampled": "directed Hausdorff"}
    return _bars(data, {title: _mean(error) for error, title in titles.items()}, _error_axis)


Value = Callable[[Sequence[Record]], float]


def _macro(rate: str) -> Value:
    return lambda records: averages(confusion(records))[rate]


def _mean(error: str) -> Value:
    def mean(records: Sequence[Record]) -> float:
        values = [record.error(error) for record in records]
        finite = [value for value in values if np.isfinite(value)]
        return max(float(np.mean(finite)), STUB) if finite else np.nan

    return mean


def _bars(data: Data, panels: dict[str, Value], finish: Callable[[Any, Any], None]) -> Any:
    """A graph for each measure, a group of bars for each method, a color for each perturbation."""
    found = shown(data, BESIDE)
    if not of_the_paper(found):
        return None
    levels = [str(level) for level in data.levels(BESIDE, "perturbation")]
    figure = make_figure(1.3 * len(found) + 3.2, 1.9 * len(panels))
    for place, (title, value) in enumerate(panels.items()):
        axes = figure.add_subplot(len(panels), 1, place + 1)
        heights = np.array([[_at(records, level, value) for level in levels] for records in found.values()])
        _groups(axes, heights, levels)
        finish(axes, heights)
        axes.set_xticks(range(len(found)), list(found), fontsize=9)
        axes.set_title(title, fontsize=10, loc="left")
        axes.tick_params(labelsize=8.5)
    handles, names = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside right upper", frameon=False, fontsize=8.5)
    return figure


def _at(records: Sequence[Record], level: str, value: Value) -> float:
    mine = grouped(records, lambda record: record.groups.get("perturbation")).get(level)
    return value(mine) if mine else np.nan


def _groups(axes: Any, heights: Any, levels: Sequence[str]) -> None:
    clean(axes)
    axes.grid(visible=False, axis="x")
    width = 0.84 / len(levels)
    for place, level in enumerate(levels):
        x = np.arange(len(heights)) + (place - (len(levels) - 1) / 2) * width
        color = COLORS[list(TYPES).index(level)] if level in TYPES else "#bbbbbb"
        axes.bar(x, heights[:, place], 0.92 * width, color=color, label=f"{level} {named(level)}")


def named(level: str) -> str:
    """A perturbation in words."""
    done = TYPES.get(level, Perturbation())
    words = [WORDS[part] for part in (done.noise, done.removal) if part] + ["deformation"] * done.bump
    return " + ".join(words) or ("clean" if level in TYPES else "")


def _share_axis(axes: Any, heights: Any) -> None:
    lowest = np.nanmin(heights, initial=1.0)
    axes.set_ylim(max(0.0, np.floor(10 * lowest - 0.5) / 10), 1.005)


def _error_axis(axes: Any, heights: Any) -> None:
    axes.set_yscale("log")
    axes.set_ylim(LEAST, max(1.0, 2.0 * np.nanmax(heights, initial=LEAST)))


PICTURES: dict[str, Picture] = {
    "six-confusion": confusions(BESIDE),
    "six-rates": rate_bars,
    "six-errors": error_bars,
    "six-sensor": confusions("sensor"),
    "six-real": confusions(REAL),
}
"""By the name of the file."""
