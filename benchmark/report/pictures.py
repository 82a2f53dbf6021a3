"""The pictures of the report; matplotlib is imported by this file alone, when one is drawn."""

from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from primfit.synthetic.recipes import KINDS

from ..records import Record
from ..scores import ANSWERS, confusion, grouped, is_close, is_exact, share
from ..track import TRACK
from . import paper
from .data import OURS, Data, described, median_seconds, of_the_paper

COLORS = {
    "primfit": "#0f6e84",
    "primfit-knn": "#56a3b3",
    "primfit-none": "#8fc1cc",
    "primfit-reversed": "#b9d8de",
    "cgal": "#d1495b",
    "engeom": "#e08e2b",
    "mesh2cad": "#4f9d69",
    "pyransac3d": "#7d5ba6",
    "scikit-spatial": "#6b7280",
    "open3d": "#1f3a5f",
    "trimesh": "#a1693f",
    "m1": "#8c6d31",
    "m2": "#cdb04a",
    "m3": "#9c4f96",
    "m4": "#c9407c",
    "m5": "#5b8c2a",
    "m6": "#3f6fb5",
    "m4-published": "#e3a3bb",
}
Picture = Callable[[Data], Any]
"""A figure, or None where the records are not enough for it."""
INK, FAINT = "#222222", "#d9dde1"
SMALLEST_ERROR, LARGEST_ERROR = 1e-17, 1e1
"""The ends of the axis of errors."""
LEVELS = {"outliers": "outliers [%]", "arcs": "arc [deg]", "exact-share": "exact [%]", "sizes": "points"}
LOGARITHMIC = ("arcs", "exact-share", "sizes")
EXACTLY = "exact-share"
"""The set of which the share is shown that is found exactly: within 1% would be easy."""


class MissingMatplotlibError(ImportError):
    """matplotlib is not installed."""

    def __init__(self) -> None:
        super().__init__("the report's pictures need matplotlib: pip install 'primfit[bench]'")


def require_matplotlib() -> None:
    """Raise `MissingMatplotlibError` before any work is done."""
    if find_spec("matplotlib") is None:
        raise MissingMatplotlibError


def draw(data: Data, folder: Path, pictures: Mapping[str, Picture]) -> set[str]:
    """Write every picture that the records are enough for; returns their names."""
    require_matplotlib()
    folder.mkdir(parents=True, exist_ok=True)
    figures = {name: picture(data) for name, picture in pictures.items()}
    drawn = {name: figure for name, figure in figures.items() if figure is not None}
    for name, figure in drawn.items():
        figure.savefig(folder / f"benchmark-{name}.png", metadata={"Software": None})
    return set(drawn)


MARKS = "filled: finds the kind    hollow: is given it    (3/5): knows three of five kinds, asked for those"


def overview(data: Data) -> Any:
    """Share right against time, on the benchmark and on scans."""
    sets = [name for name in ("shrec", "scanner") if name in data.sets]
    if not sets:
        return None
    figure = make_figure(5.2 * len(sets), 4.4)
    for place, set_ in enumerate(sets):
        axes = figure.add_subplot(1, len(sets), place + 1, sharex=figure.axes[0] if place else None)
        axes.set_xscale("log")
        for method in _with_records(data, set_):
            records = data.of_set(set_, method)
            _mark(axes, data, method, 1e3 * median_seconds(records), 100 * share(records, is_close))
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.set_xlabel("time a cloud, median [ms]")
        axes.set_ylim(-4, 108)
        axes.set_title(described(set_).title, fontsize=10.5, loc="left")
        axes.margins(x=0.18)
        clean(axes)
        if place == 0:
            axes.set_ylabel("kind right and surface within 1% [% of the clouds]")
    if not all(map(data.decides, data.methods)):
        figure.supxlabel(MARKS, fontsize=8.5, color=INK)
    figure.draw_without_rendering()
    for axes in figure.axes:
        _name_marks(axes, {method: _known(data, method) for method in data.methods})
    return figure


LABEL_PLACES = (
    (0, 9, "center"),
    (0, -16, "center"),
    (9, -3, "left"),
    (-9, -3, "right"),
    (9, 9, "left"),
    (-9, 9, "right"),
    (9, -16, "left"),
    (-9, -16, "right"),
    (0, -27, "center"),
    (9, -27, "left"),
    (-9, -27, "right"),
)
"""Where a name may stand from its mark: points to the right and up, and its alignment, the best first."""
MARK = 9
"""Half the side of the square that a mark takes, in pixels."""


def _known(data: Data, method: str) -> str:
    """The name, with how many kinds the method knows, if not all."""
    number = len(data.about[method]["kinds"])
    return method if number == len(KINDS) else f"{method} ({number}/{len(KINDS)})"


def _name_marks(axes: Any, names: Mapping[str, str]) -> None:
    """The names of the marks, each where it covers no mark and no other name, if there is such a place."""
    from matplotlib.transforms import Bbox

    marks = {mark.get_label(): mark.get_offsets()[0] for mark in axes.collections}
    pixels = axes.transData.transform(list(marks.values()))
    taken = [Bbox([at - MARK, at + MARK]) for at in pixels]
    for method, at in marks.items():
        texts = [_name_mark(axes, method, names[method], at, *place) for place in LABEL_PLACES]
        boxes = [text.get_window_extent() for text in texts]
        free = (k for k, box in enumerate(boxes) if box.count_overlaps(taken) == 0 and axes.bbox.y1 > box.y1)
        chosen = next(free, 0)
        taken.append(boxes[chosen])
        for k, text in enumerate(texts):
            if k != chosen:
                text.remove()


def _name_mark(axes: Any, method: str, name: str, at: Any, right: int, up: int, alignment: str) -> Any:
    return axes.annotate(
        name,
        at,
        xytext=(right, up),
        textcoords="offset points",
        ha=alignment,
        fontsize=8.5,
        color=COLORS[method],
        weight="bold" if method == OURS else "normal",
    )


def _mark(axes: Any, data: Data, method: str, x: float, y: float) -> None:
    color = COLORS[method]
    face = color if data.decides(method) else "white"
    size = 120 if method == OURS else 60
    axes.scatter([x], [y], s=size, facecolor=face, edgecolor=color, linewidths=1.8, zorder=3, label=method)


def errors(data: Data) -> Any:
    """The share of the clouds whose error is below a bound: L2 beside the paper's quartiles, and on scans."""
    panels = [(name, error) for name, error in (("shrec", "l2"), ("scanner", "surface")) if name in data.sets]
    if not panels:
        return None
    figure = make_figure(4.6 * len(panels) + 2.2, 4.4)
    for place, (set_, error) in enumerate(panels):
        axes = figure.add_subplot(1, len(panels), place + 1)
        for method in _with_records(data, set_):
            values = np.sort([record.error(error) for record in data.of_set(set_, method)])
            shown = np.clip(values[np.isfinite(values)], SMALLEST_ERROR, LARGEST_ERROR)
            below = 100 * np.arange(1, len(shown) + 1) / len(values)
            axes.step(
                np.append(shown, LARGEST_ERROR),
                np.append(below, below[-1:]),
                where="post",
                **_line(data, method),
            )
        if error == "l2":
            _paper_quartiles(axes)
        axes.set_xscale("log")
        axes.set_xlim(SMALLEST_ERROR if error == "l2" else 1e-6, LARGEST_ERROR)
        axes.set_ylim(0, 101)
        axes.set_xlabel("L2 [unit of the clouds]" if error == "l2" else "surface error [share of the extent]")
        axes.set_title(described(set_).title, fontsize=10.5, loc="left")
        clean(axes)
        if place == 0:
            axes.set_ylabel("clouds with a smaller error [%]")
    _legend(figure)
    return figure


def _paper_quartiles(axes: Any) -> None:
    for name, numbers in paper.ERRORS["l2"].items():
        best = name == "M4"
        axes.plot(
            numbers[:3],
            (25, 50, 75),
            marker="o",
            markersize=4 if best else 3,
            linewidth=1.2 if best else 0.7,
            linestyle=":",
            color="#444444" if best else "#aaaaaa",
            label="M4 (paper): quartiles" if best else "M1 to M6 (paper)" if name == "M6" else None,
            zorder=1,
        )


def confusions(data: Data) -> Any:
    """Confusion matrices of those that find the kind, in percent of a row."""
    sets = [name for name in (TRACK, "shrec", "scanner") if name in data.sets]
    pairs = [(set_, m) for m in _main(data.deciders()) for set_ in sets if data.of_set(set_, m)]
    if not pairs:
        return None
    columns = len({set_ for set_, _ in pairs})
    rows = -(-len(pairs) // columns)
    figure = make_figure(4.9 * columns, 3.5 * rows)
    for place, (set_, method) in enumerate(pairs):
        counts = confusion(data.of_set(set_, method))
        shares = 100 * counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
        axes = figure.add_subplot(rows, columns, place + 1)
        texts = [[_share_text(value) for value in row] for row in shares]
        heatmap(
            axes, shares, texts, KINDS, [name.replace("_", " ") for name in ANSWERS], good=np.eye(5, 8) > 0
        )
        axes.set_title(f"{method} · {described(set_).title} [%]", fontsize=9.5, loc="left")
        if place % columns == 0:
            axes.set_ylabel("truth", fontsize=8.5)
    return figure


def _share_text(value: float) -> str:
    return "" if value == 0 else f"{value:.0f}" if value >= 9.95 or value == round(value) else f"{value:.1f}"


def perturbations(data: Data) -> Any:
    """Share right and within 1% by method and perturbation."""
    sets = [name for name in (TRACK, "shrec") if name in data.sets]
    if not sets:
        return None
    counts = [len(_with_records(data, set_)) for set_ in sets]
    figure = make_figure(8.4, 0.36 * sum(counts) + len(sets) + 0.3)
    grid = figure.add_gridspec(len(sets), 1, height_ratios=[0.36 * number + 0.3 for number in counts])
    for place, set_ in enumerate(sets):
        methods = _with_records(data, set_)
        levels = [level for level in data.levels(set_, "perturbation")]
        at = grouped(data.of_set(set_), lambda record: (record.method, record.groups["perturbation"]))
        cells = [[100 * share(at.get((m, level), []), is_close) for level in levels] for m in methods]
        axes = figure.add_subplot(grid[place])
        texts = [["" if np.isnan(value) else f"{value:.0f}" for value in row] for row in cells]
        names = [m if data.decides(m) else f"{m} (kind given)" for m in methods]
        heatmap(axes, np.array(cells), texts, names, [str(level) for level in levels])
        axes.set_title(f"{described(set_).title}: right and within 1% [%]", fontsize=10.5, loc="left")
    return figure


def heatmap(
    axes: Any,
    values: np.ndarray,
    texts: Sequence[Sequence[str]],
    rows: Sequence[str],
    columns: Sequence[str],
    good: np.ndarray | None = None,
) -> None:
    """Cells with numbers: the higher the greener; where `good` is False the higher the redder."""
    from matplotlib.colors import LinearSegmentedColormap

    green = LinearSegmentedColormap.from_list("green", ["#ffffff", "#0f6e84"])
    red = LinearSegmentedColormap.from_list("red", ["#ffffff", "#d1495b"])
    shade = np.nan_to_num(values / 100)
    picture = green(shade)
    if good is not None:
        picture = np.where(good[..., None], picture, red(np.sqrt(shade)))
    axes.imshow(picture, aspect="auto")
    for i, row in enumerate(texts):
        for j, text in enumerate(row):
            dark = shade[i, j] > 0.55 or (good is not None and not good[i, j] and shade[i, j] > 0.4)
            axes.text(j, i, text, ha="center", va="center", fontsize=8, color="white" if dark else INK)
    axes.set_xticks(
        range(len(columns)), columns, fontsize=8, rotation=0 if len(max(columns, key=len)) < 6 else 35
    )
    axes.set_yticks(range(len(rows)), rows, fontsize=8)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)


def levels(data: Data) -> Any:
    """Share right and within 1% against outliers, arc, exact share and number of points."""
    sets = [name for name in LEVELS if name in data.sets]
    if not sets:
        return None
    figure = _lines(data, sets, _share_of)
    for axes, set_ in zip(figure.axes, sets, strict=True):
        axes.set_ylabel("right and exact [%]" if set_ == EXACTLY else "right and within 1% [%]", fontsize=9)
        axes.set_ylim(-4, 104)
    return figure


def times(data: Data) -> Any:
    """Time against the number of points."""
    if "sizes" not in data.sets:
        return None
    figure = _lines(data, ["sizes"], lambda set_, records: 1e3 * median_seconds(records))
    figure.axes[0].set_ylabel("time a cloud, median [ms]")
    figure.axes[0].set_yscale("log")
    figure.axes[0].yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    return figure


def _share_of(set_: str, records: Sequence[Record]) -> float:
    return 100 * share(records, is_exact if set_ == EXACTLY else is_close)


def _lines(data: Data, sets: Sequence[str], measure: Callable[[str, list[Record]], float]) -> Any:
    columns = min(2, len(sets))
    rows = -(-len(sets) // columns)
    figure = make_figure((5.0 if columns > 1 else 7.0) * columns, 3.5 * rows if columns > 1 else 4.2)
    for place, set_ in enumerate(sets):
        axes = figure.add_subplot(rows, columns, place + 1)
        group = LEVELS[set_]
        for method in _with_records(data, set_):
            at = grouped(data.of_set(set_, method), lambda record: record.groups[group])  # noqa: B023
            x = sorted(at)
            axes.plot(
                x,
                [measure(set_, at[level]) for level in x],
                marker="o",
                markersize=3.5,
                **_line(data, method),
            )
        if set_ in LOGARITHMIC:
            axes.set_xscale("log")
            ticks = data.levels(set_, group)
            axes.set_xticks(ticks, [_short(float(tick)) for tick in ticks])
            axes.minorticks_off()
        if set_ == "arcs":
            axes.invert_xaxis()
        axes.set_xlabel(group)
        axes.set_title(described(set_).title, fontsize=10.5, loc="left")
        axes.tick_params(labelsize=8.5)
        clean(axes)
    _legend(figure)
    return figure


def _short(number: float) -> str:
    """1,000 as 1k, 1,000,000 as 1M."""
    return f"{number / 1e6:g}M" if number >= 1e6 else f"{number / 1e3:g}k" if number >= 1e3 else f"{number:g}"


def _legend(figure: Any) -> None:
    """One for all panels, beside them."""
    handles, names = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside right upper", frameon=False, fontsize=8.5)


def _with_records(data: Data, set_: str) -> list[str]:
    return [method for method in data.methods if data.of_set(set_, method)]


def _main(methods: Sequence[str]) -> list[str]:
    """Without the variants of primfit, and without the paper's methods, which have pictures of their own."""
    apart = of_the_paper(methods)
    return [m for m in methods if m == OURS or not (m.startswith(OURS) or m in apart)]


def _line(data: Data, method: str) -> dict[str, Any]:
    decides = data.decides(method)
    return {
        "color": COLORS[method],
        "linewidth": 2.4 if method == OURS else 1.3,
        "linestyle": "-" if decides else "--",
        "label": method if decides else f"{method} (kind given)",
        "zorder": 5 if method == OURS else 3,
    }


def make_figure(width: float, height: float) -> Any:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def clean(axes: Any) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color=FAINT, linewidth=0.6)
    axes.set_axisbelow(True)


PICTURES: dict[str, Picture] = {
    "overview": overview,
    "perturbations": perturbations,
    "errors": errors,
    "confusion": confusions,
    "levels": levels,
    "time": times,
}
"""By the name of the file."""
