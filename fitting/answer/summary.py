"""An answer in words and aligned numbers: the rows that `print` and the command line show."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from ..extents import EXTENTS
from ..plain import worded
from ..primitives import DIRECTIONS, is_angle

Row = tuple[str, str]
"""A label, empty where it is that of the row before, and what stands beside it."""

SYMMETRIC = 0.05
"""Relative difference of the two halves of an interval up to which it is shown as one half-width."""

BESIDE = ("error", "extents", "uncertainty", "evidence")
"""What stands beside the parameters of an alternative."""

_LABEL_WIDTH = 14
_COLUMN = 16


def summary(answer: Mapping[str, Any]) -> str:
    """The answer (`Recognition.to_dict`) as lines of text."""
    tried = ", ".join(f"{attempt['kind']} ({attempt['outcome']})" for attempt in answer["attempts"])
    rows = [row for section in sections(answer) for row in section]
    lines = [f"{label:<{_LABEL_WIDTH}}{text}".rstrip() for label, text in [*rows, ("tried", tried)]]
    return "\n".join([f"{worded(answer['status'])}  {answer['message']}", *lines])


def sections(answer: Mapping[str, Any]) -> list[list[Row]]:
    """What an answer says beside its status and its trail, in groups of rows."""
    known, groups = answer["uncertainty"], []
    if answer["primitive"] is not None:
        label = "best try" if answer["status"] == "no_fit" else "kind"
        groups.append(list(_parameters(answer["primitive"], label, known)))
    if answer["extents"] is not None:
        groups.append(_extents(answer["extents"]))
    if known is not None and known["warnings"]:
        groups.append([("warning", warning["message"]) for warning in known["warnings"]])
    if answer["error"] is not None:
        groups.append(_error(answer["error"], answer["noise"]))
    groups += [list(_alternative(other)) for other in answer["alternatives"]]
    if answer["active_constraints"]:
        effects = answer["active_constraints"].items()
        groups.append(_labelled("constraints", [f"{worded(name)}: {effect}" for name, effect in effects]))
    return groups


def _alternative(other: Mapping[str, Any]) -> Iterator[Row]:
    """Its kind and parameters as those of the primitive, its distances, and what to beware of."""
    primitive = {name: value for name, value in other.items() if name not in BESIDE}
    yield from _parameters(primitive, "or", other["uncertainty"])
    yield from _distances(other["error"])
    for warning in (other["uncertainty"] or {"warnings": []})["warnings"]:
        yield "warning", warning["message"]


def _labelled(label: str, texts: list[str]) -> list[Row]:
    return [("" if i else label, text) for i, text in enumerate(texts)]


def _parameters(primitive: Mapping[str, Any], label: str, known: Mapping[str, Any] | None) -> Iterator[Row]:
    """The kind and a row for each parameter, with its 95 % interval; for coordinates that is the next row."""
    intervals = {} if known is None else known["intervals"]
    yield label, primitive["kind"] + (", with 95 % intervals" if intervals else "")
    direction = None if known is None else known["direction"]
    for name, value in primitive.items():
        if isinstance(value, list):
            yield from _vector(name, value, intervals, direction)
        elif name != "kind":
            unit = f" rad = {_plain(math.degrees(value))} degrees" if is_angle(name) else ""
            interval = intervals.get(name)
            yield worded(name), _aligned(_known_to(value, interval)) + _within(value, interval) + unit
    if known is not None and known["position"] is not None:
        across = "axis" if "axis" in primitive else primitive["kind"]
        radius = f"± {known['position']['radius_95']:.2g}"
        yield "position", f"{_aligned(radius)}  across the {across}"


def _vector(
    name: str, value: list[float], intervals: Mapping[str, Any], direction: Mapping[str, Any] | None
) -> Iterator[Row]:
    each_interval = [intervals.get(f"{name}.{axis}") for axis in "xyz"]
    numbers = "".join(map(_aligned, map(_known_to, value, each_interval)))
    if direction is not None and name in DIRECTIONS:
        numbers += f"  ± {math.degrees(direction['radius_95']):.2g} degrees"
    yield worded(name), numbers
    halves = list(map(_half_width, value, each_interval))
    if any(halves):
        yield "", "".join(_aligned(half) for half in halves)


def _half_width(value: float, interval: Mapping[str, Any] | None) -> str:
    """The longer half of an interval, or that an end is open; nothing where the value is held."""
    if interval is None or interval["method"] == "held":
        return ""
    if None in (interval["low"], interval["high"]):
        return "open"
    return f"± {max(value - interval['low'], interval['high'] - value):.2g}"


def _within(value: float, interval: Mapping[str, Any] | None) -> str:
    """The interval of a number: as a half-width, by its ends where it leans to one side, or what is known."""
    if interval is None or interval["method"] == "held":
        return ""
    low, high = interval["low"], interval["high"]
    if low is None or high is None:
        ends = [
            f"{word} {_plain(end)}" for word, end in (("at least", low), ("at most", high)) if end is not None
        ]
        return "  " + ("".join(ends) or "not bounded by the points")
    below, above = value - low, high - value
    if abs(above - below) <= SYMMETRIC * max(above, below):
        return f"  {_half_width(value, interval)}"
    return f"  {_plain(low)} to {_plain(high)}"


def _extents(extents: Mapping[str, Any]) -> list[Row]:
    area = f"area {extents['area']:.6g}, of which {extents['coverage']:.0%} have points near them"
    return _labelled("extents", [*EXTENTS[extents["kind"]].words(extents), area])


def _distances(error: Mapping[str, float]) -> list[Row]:
    """Of all points, and of the inliers."""
    every = "  ".join(f"{name} {error[key]:.3g}" for name, key in _LENGTHS)
    return [("error", every), ("", f"rms of the inliers {error['inlier_rms']:.3g}")]


def _error(error: Mapping[str, float], noise: Mapping[str, Any]) -> list[Row]:
    shares = (f"{name} {noise[f'{name}_share']:.1%}" for name in ("exact", "outlier"))
    step = noise["quantisation_step"]
    return [
        *_distances(error),
        ("", f"mean over the bounding-box diagonal {error['relative_mean']:.3g}"),
        ("points", "  ".join((f"inlier {error['inlier_share']:.1%}", *shares))),
        ("noise", f"{noise['scale']:.3g}" + (f"  coordinates in steps of {step:g}" if step else "")),
        *(("", text) for text in _deviations(noise)),
    ]


def _deviations(noise: Mapping[str, Any]) -> Iterator[str]:
    """What neighbouring points have in common, in words."""
    for name, said in _SHARED.items():
        if (found := noise[name]) is not None:
            yield f"{said} {found['size']:.3g} over {found['range']:.3g}"


_SHARED = {
    "correlated": "neighbouring points share a deviation of",
    "smooth": "the points deviate smoothly by",
}


_LENGTHS = (("rms", "rms"), ("mean", "mean"), ("95 %", "p95"), ("max", "max"), ("zone", "zone"))


def _plain(value: float) -> str:
    return f"{value:.9g}"


def _known_to(value: float, interval: Mapping[str, Any] | None) -> str:
    """With two digits of its standard deviation, far from the origin too, as long as a column holds them."""
    deviation = 0.0 if interval is None else interval["standard_deviation"]
    if not value or not deviation:
        return _plain(value)
    digits = math.floor(math.log10(abs(value))) - math.floor(math.log10(deviation)) + 2
    fitting = (f"{value:.{n}g}" for n in range(min(digits, 17), 9, -1))
    return next((text for text in fitting if len(text) < _COLUMN), _plain(value))


def _aligned(text: str) -> str:
    return f"{text:>{_COLUMN}}"
