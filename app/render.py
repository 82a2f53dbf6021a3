"""An answer for people: the primitive, its error and the trail of attempts, on a terminal."""

import math
from collections.abc import Callable, Mapping
from typing import Any

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.rule import Rule
from rich.table import Table
from rich.text import Text

COLOR = {
    "fitted": "green",
    "ambiguous": "yellow",
    "no_fit": "red",
    "accepted": "green",
    "refused": "yellow",
    "failed": "red",
}


def render(name: str, body: Mapping[str, Any]) -> RenderableType:
    """The answer of one file (the body of `POST /fit`) as a rich renderable."""
    status = body["status"]
    receipt = body["receipt"]
    title = Text.assemble(
        (name, "bold"),
        f"  {receipt['n_points']:,} points, {receipt['format']} {' '.join(receipt['columns'])}",
    )
    found = Text.assemble((status.replace("_", " "), f"bold {COLOR[status]}"), "  ", body["message"])
    parts: list[RenderableType] = [Rule(title, align="left", style="dim"), found]
    if body["primitive"] is not None:
        label = "best try" if status == "no_fit" else "kind"
        parts.append(Padding(_parameters(body["primitive"], label), (1, 0, 0, 0)))
    parts += [Padding(_parameters(other, "or"), (1, 0, 0, 0)) for other in body["alternatives"]]
    if body["extents"] is not None:
        parts.append(Padding(_extents(body["extents"]), (1, 0, 0, 0)))
    if body["uncertainty"] is not None:
        parts.append(Padding(_uncertainty(body["uncertainty"]), (1, 0, 0, 0)))
    if body["error"] is not None:
        parts.append(Padding(_error(body["error"], body["noise"]), (1, 0, 0, 0)))
    if body["active_constraints"]:
        parts.append(Padding(_constraints(body["active_constraints"]), (1, 0, 0, 0)))
    parts.append(Padding(_attempts(body["attempts"]), (1, 0, 1, 0)))
    return Group(*parts)


def _grid() -> Table:
    grid = Table.grid(padding=(0, 2, 0, 0), pad_edge=True)
    grid.add_column(style="dim", no_wrap=True, min_width=12)
    return grid


def _parameters(primitive: Mapping[str, Any], label: str) -> Table:
    grid = _grid()
    grid.add_row(label, Text(primitive["kind"], "bold"))
    for name, value in primitive.items():
        if name == "kind":
            continue
        shown = "  ".join(_number(v) for v in value) if isinstance(value, list) else _number(value)
        if name == "half_angle":
            shown += f" rad = {_plain(math.degrees(value))} degrees"
        grid.add_row(name.replace("_", " "), shown)
    return grid


def _extents(extents: Mapping[str, Any]) -> Table:
    grid = _grid()
    for i, line in enumerate(_SHAPES[extents["kind"]](extents)):
        grid.add_row("" if i else "extents", line)
    grid.add_row("", f"area {extents['area']:.6g}, of which {extents['coverage']:.0%} have points near them")
    return grid


def _arc(of: Mapping[str, Any], prefix: str = "") -> str:
    if of[f"{prefix}full_turn"]:
        return "a full turn"
    start, span = (math.degrees(of[f"{prefix}{name}"]) for name in ("start_angle", "span"))
    return f"{span:.5g} degrees, from {start:.5g}"


def _cap(of: Mapping[str, Any]) -> str:
    if of["full_sphere"]:
        return "the full sphere"
    return f"a cap of half-angle {math.degrees(of['half_angle']):.5g} degrees, height {of['height']:.6g}"


_SHAPES: dict[str, Callable[[Mapping[str, Any]], list[str]]] = {
    "plane": lambda of: [
        f"{of['length']:.6g} x {of['width']:.6g}, an outline of {len(of['outline'])} corners"
    ],
    "sphere": lambda of: [_cap(of)],
    "cylinder": lambda of: [f"length {of['length']:.6g}", _arc(of)],
    "cone": lambda of: [
        f"height {of['start_height']:.6g} to {of['end_height']:.6g} from the apex",
        f"radius {of['start_radius']:.6g} to {of['end_radius']:.6g}",
        _arc(of),
    ],
    "torus": lambda of: [f"around the axis {_arc(of)}", f"around the tube {_arc(of, 'tube_')}"],
}


def _uncertainty(known: Mapping[str, Any]) -> Table:
    """95 % intervals of the sizes, the direction and the position, and the warnings."""
    grid = _grid()
    rows = [
        (name, _between(interval))
        for name, interval in known["intervals"].items()
        if "." not in name and interval["method"] != "held"
    ]
    if known["direction"] is not None:
        rows.append(("direction", f"within {math.degrees(known['direction']['radius_95']):.3g} degrees"))
    if known["position"] is not None:
        rows.append(("position", f"within {known['position']['radius_95']:.3g}"))
    for i, (name, told) in enumerate(rows):
        grid.add_row("" if i else "95 %", f"{name.replace('_', ' ')} {told}")
    for warning in known["warnings"]:
        grid.add_row(Text("warning", "yellow"), warning["message"])
    return grid


def _between(interval: Mapping[str, Any]) -> str:
    low, high = interval["low"], interval["high"]
    if low is None or high is None:
        known = [f"{word} {_plain(end)}" for word, end in (("from", low), ("to", high)) if end is not None]
        return " ".join(known) or "not bounded by the points"
    return f"{_plain(low)} to {_plain(high)}"


def _error(error: Mapping[str, float], noise: Mapping[str, float | None]) -> Table:
    grid = _grid()
    grid.add_row("error", "  ".join(f"{name} {error[key]:.3g}" for name, key in _LENGTHS))
    grid.add_row("", f"mean over the bounding-box diagonal {error['relative_mean']:.3g}")
    shares = (f"{name} {noise[f'{name}_share']:.1%}" for name in ("exact", "outlier"))
    grid.add_row("points", "  ".join((f"inlier {error['inlier_share']:.1%}", *shares)))
    step = noise["quantisation_step"]
    grid.add_row("noise", f"{noise['scale']:.3g}" + (f"  coordinates in steps of {step:g}" if step else ""))
    return grid


def _constraints(effects: Mapping[str, str]) -> Table:
    grid = _grid()
    for i, (name, effect) in enumerate(effects.items()):
        grid.add_row("" if i else "constraints", f"{name.replace('_', ' ')}: {effect}")
    return grid


_LENGTHS = (("rms", "rms"), ("mean", "mean"), ("95 %", "p95"), ("max", "max"), ("zone", "zone"))


def _attempts(attempts: list[Mapping[str, Any]]) -> Table:
    table = Table(box=None, header_style="dim", padding=(0, 2, 0, 0), pad_edge=False)
    table.add_column("tried", no_wrap=True)
    table.add_column("rank", justify="right", no_wrap=True)
    table.add_column("mean error", justify="right", no_wrap=True)
    table.add_column("outcome", no_wrap=True)
    table.add_column("why", ratio=1)
    for attempt in attempts:
        probability, error, outcome = attempt["probability"], attempt["error"], attempt["outcome"]
        table.add_row(
            attempt["kind"],
            "-" if probability is None else f"{probability:.3f}",
            "-" if error is None else f"{error['mean']:.3g}",
            Text(outcome, COLOR[outcome]),
            attempt["reason"],
        )
    return table


def _plain(value: float) -> str:
    return f"{value:.9g}"


def _number(value: float) -> str:
    return f"{_plain(value):>14}"
