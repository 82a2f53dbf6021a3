"""An answer in words and aligned numbers: the rows that `print`, the command line and the report show."""

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from ..extents import EXTENTS
from ..extents.values import Row, large
from ..plain import worded
from ..primitives import DIRECTIONS, direction_of, is_angle, is_length
from ..words import DIGITS, as_given, between, digits, figure, listed, part, with_unit

SYMMETRIC = 0.05
"""Relative difference of the two halves of an interval up to which it is shown as one half-width."""

BESIDE = ("error", "extents", "uncertainty", "evidence")
"""What stands beside the parameters of an alternative."""

WELL_KNOWN = 12
"""Digits of a number that is known to more, or exactly."""

VERDICTS = {
    "within": "within tolerance",
    "beyond": "beyond tolerance",
    "undecided": "undecided: an interval reaches over its tolerance",
}

OTHER_SHAPE = "another shape than asked for"

_LABEL_WIDTH = 17
_COLUMN = 17
_HALF = 2
"""Digits of half an interval."""

Answer = Mapping[str, Any]
"""Plain values, as `Recognition.to_dict` gives them; a `receipt` among them has `n_points` and `unit`."""


def summary(answer: Answer) -> str:
    """The answer as lines of text."""
    tried = ", ".join(f"{attempt['kind']} ({attempt['outcome']})" for attempt in answer["attempts"])
    status = (worded(answer["status"]), answer["message"])
    rows = [*headline(answer), status, *(row for section in sections(answer) for row in section)]
    lines = [f"{label:<{_LABEL_WIDTH}}{text}".rstrip() for label, text in [*rows, ("tried", tried)]]
    return "\n".join(lines)


def headline(answer: Answer) -> list[Row]:
    """What one looks for first: kind, sizes, where it ends, form error, and the points that belong to it.

    After ± stands half of a 95% interval; of one that leans to one side both ends stand there.
    """
    if answer["primitive"] is None:
        return list(_conformance(answer))
    label = "best try" if answer["status"] == "no_fit" else "kind"
    (_, kind), *rows = _found(label, answer["primitive"], answer, answer)
    if others := [other["kind"] for other in answer["alternatives"]]:
        kind += f"; or a {listed(others, 'or')}, see below"
    return [(label, kind), *rows, *_conformance(answer)]


def _found(label: str, primitive: Mapping[str, Any], beside: Answer, answer: Answer) -> Iterator[Row]:
    """The headline of the answer or of an alternative, with what stands `beside` its parameters."""
    unit, known, extents = _unit(answer), beside["uncertainty"], beside["extents"]
    intervals = {} if known is None else known["intervals"]
    yield label, primitive["kind"] + (", with 95% intervals" if intervals else "")
    for name, value in primitive.items():
        if not isinstance(value, list | str):
            yield from _size(name, value, intervals.get(name), unit)
    if extents is not None:
        yield EXTENTS[extents["kind"]].words(extents, unit)[0]
    if beside["error"] is not None:
        yield from _quality(beside["error"], answer)


def _size(name: str, value: float, interval: Mapping[str, Any] | None, unit: str | None) -> Iterator[Row]:
    """A radius or a half-angle; of what has one radius the diameter first."""
    if is_angle(name):
        degrees = _times(math.degrees(1.0), interval)
        yield worded(name), f"{measured(math.degrees(value), degrees, 'degrees')} = {figure(value, 'rad', 6)}"
        return
    if name == "radius":
        yield "diameter", measured(2.0 * value, _times(2.0, interval), unit)
    yield worded(name), measured(value, interval, unit)


def _times(factor: float, interval: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """An interval of a multiple of a number."""
    if interval is None:
        return None
    ends = {end: interval[end] and factor * interval[end] for end in ("low", "high")}
    return {**interval, **ends}


def measured(value: float, interval: Mapping[str, Any] | None, unit: str | None) -> str:
    """A number to the digits that are known, with what is known of it: `12.503 ± 0.021 mm`."""
    if interval is None:
        return with_unit(f"{value:.9g}", unit)
    if interval["method"] == "held":
        return with_unit(f"{value:.{WELL_KNOWN}g}", unit) + ", fixed"
    low, high = interval["low"], interval["high"]
    if low is None or high is None:
        return f"{figure(value, unit, 6)} ({between(low, high, unit)})"
    half = max(value - low, high - value)
    shown = _to_digits_of(value, half)
    if abs(high + low - 2.0 * value) <= SYMMETRIC * half:
        return with_unit(f"{shown} \u00b1 {digits(half, _HALF)}", unit)
    return f"{with_unit(shown, unit)} ({between(low, high, unit)})"


def _to_digits_of(value: float, half: float) -> str:
    """A number down to the last digit of half its interval, where it has that many."""
    if not half:
        return f"{value:.{WELL_KNOWN}g}"
    decimals = _HALF - 1 - math.floor(math.log10(half))
    n_digits = math.floor(math.log10(abs(value) or 1.0)) + 1 + decimals
    if n_digits > WELL_KNOWN:
        return f"{value:.{WELL_KNOWN}g}"
    return digits(value, max(n_digits, 1))


def _quality(error: Mapping[str, float], answer: Answer) -> Iterator[Row]:
    """The form error, and how many points belong to the surface and how they scatter."""
    unit, n_points = _unit(answer), _n_points(answer)
    share = error["inlier_share"]
    over = "all points" if share == 1.0 else "the inliers"
    yield "form error", f"{figure(error['inlier_zone'], unit)}, over {over}"
    if n_points is None:
        count = f"{part(share)} of the points"
    elif share == 1.0:
        count = f"all {n_points:,}"
    else:
        count = f"{round(share * n_points):,} of {n_points:,}"
    yield "inliers", f"{count}, rms {figure(error['inlier_rms'], unit)}"


def _receipt(answer: Answer) -> Mapping[str, Any]:
    return answer.get("receipt") or {}


def _unit(answer: Answer) -> str | None:
    return _receipt(answer).get("unit")


def _n_points(answer: Answer) -> int | None:
    """Points that were judged; with weights some may have been left out, and it is not known how many."""
    receipt = _receipt(answer)
    return None if receipt.get("weights_sha256") else receipt.get("n_points")


def sections(answer: Answer) -> list[list[Row]]:
    """What an answer says beside its headline, its status and its trail, in groups of rows."""
    known, unit = answer["uncertainty"], _unit(answer)
    groups = []
    if answer["primitive"] is not None:
        groups.append(list(_place(answer["primitive"], known, unit)))
    if answer["extents"] is not None:
        groups.append(_extents(answer["extents"], unit))
    groups.append([("warning", text) for text in _warnings(answer)])
    if answer["error"] is not None:
        groups.append([*_error(answer["error"], unit), *_noise(answer["noise"], unit)])
    groups += [list(_alternative(other, answer)) for other in answer["alternatives"]]
    effects = answer["active_constraints"].items()
    groups.append(_labeled("constraints", [f"{worded(name)}: {effect}" for name, effect in effects]))
    return [group for group in groups if group]


def _conformance(answer: Answer) -> Iterator[Row]:
    """What was asked for, and what became of it."""
    found = answer.get("conformance") or {"verdict": None, "checks": []}
    if found["verdict"] is not None:
        yield "verdict", _verdict(found, answer)
    for check in found["checks"]:
        yield worded(check["name"]), _check(check, _unit(answer))


def _verdict(found: Mapping[str, Any], answer: Answer) -> str:
    first = (answer["primitive"] or {}).get("kind")
    return verdict_in_words(found["verdict"], found["kind"], answer["status"], first)


def verdict_in_words(verdict: str, kind: str | None, status: str, first: str | None) -> str:
    """A verdict on a kind, which is named where it is not the first one of the answer."""
    if kind is None:
        return "beyond tolerance: no kind explains the points" if status == "no_fit" else OTHER_SHAPE
    word, colon, why = VERDICTS[verdict].partition(": ")
    return word + ("" if kind == first else f" as a {kind}") + colon + why


def _check(check: Mapping[str, Any], length: str | None) -> str:
    """A deviation with its interval, what is allowed, and the verdict."""
    name, low, high = check["name"], check["low"], check["high"]
    limits = [] if check["upper"] is None else [check["lower"], check["upper"]]
    unit = length if name == "form" or is_length(name) else "rad"
    deviation = figure(check["deviation"], unit, _digits_beside(check["deviation"], limits))
    text = f"{'error' if name == 'form' else 'deviation'} {deviation}"
    if low is not None or high is not None:
        text += f" ({between(low, high, unit)})"
    if not limits:
        return text
    if low is None and high is None and name != "form":
        text += f" ({between(None, None) if check['verdict'] == 'undecided' else 'interval not known'})"
    one_sided = name == "form" or isinstance(check["nominal"], list)
    lower, upper = limits
    allowed = f"up to {as_given(upper, unit)}" if one_sided else _limits(lower, upper, unit)
    return f"{text}, allowed {allowed}: {check['verdict']}"


def _limits(lower: float, upper: float, unit: str | None) -> str:
    """Deviations of a number that are allowed, as they were given."""
    if lower == upper:
        return as_given(upper, unit)
    if lower == -upper:
        return f"\u00b1 {as_given(upper, unit)}"
    return f"{as_given(lower)} to {as_given(upper, unit)}"


def _digits_beside(value: float, limits: Iterable[float]) -> int:
    """As many digits as tell a number from limits that it is not."""
    others = [limit for limit in limits if limit != value]
    enough = (n for n in range(DIGITS, WELL_KNOWN) if all(digits(value, n) != digits(o, n) for o in others))
    return next(enough, WELL_KNOWN)


def _warnings(answer: Answer) -> list[str]:
    """Of the points, and of what is known of the parameters."""
    known = answer["uncertainty"] or {"warnings": []}
    return [*answer.get("warnings", ()), *(warning["message"] for warning in known["warnings"])]


def _alternative(other: Answer, answer: Answer) -> Iterator[Row]:
    """Its headline, where it is, its distances, and what to beware of."""
    primitive = {name: value for name, value in other.items() if name not in BESIDE}
    yield from _found("or", primitive, other, answer)
    yield from _place(primitive, other["uncertainty"], _unit(answer))
    yield _distances(other["error"], _unit(answer))
    yield from (
        ("warning", warning["message"]) for warning in (other["uncertainty"] or {"warnings": []})["warnings"]
    )


def _labeled(label: str, texts: list[str]) -> list[Row]:
    return [("" if i else label, text) for i, text in enumerate(texts)]


def _place(primitive: Mapping[str, Any], known: Mapping[str, Any] | None, unit: str | None) -> Iterator[Row]:
    """A row for each position and direction, with the intervals of coordinates in the next row."""
    intervals = {} if known is None else known["intervals"]
    direction = None if known is None else known["direction"]
    for name, value in primitive.items():
        if isinstance(value, list):
            yield from _vector(name, value, intervals, direction, unit)
    if known is not None and known["position"] is not None:
        across = "axis" if direction_of(primitive["kind"]) == "axis" else primitive["kind"]
        radius = f"\u00b1 {digits(known['position']['radius_95'], _HALF)}"
        yield "position", with_unit(_aligned(radius), unit) + f", across the {across}"


def _vector(
    name: str,
    value: list[float],
    intervals: Mapping[str, Any],
    direction: Mapping[str, Any] | None,
    unit: str | None,
) -> Iterator[Row]:
    each_interval = [intervals.get(f"{name}.{axis}") for axis in "xyz"]
    numbers = "".join(map(_aligned, map(_known_to, value, each_interval)))
    if name in DIRECTIONS:
        yield worded(name), numbers
        if direction is not None:
            off = f"\u00b1 {digits(math.degrees(direction['radius_95']), _HALF)}"
            yield "", f"{_aligned(off)} degrees"
        return
    yield worded(name), with_unit(numbers, unit)
    halves = list(map(_half_width, value, each_interval))
    if any(halves):
        yield "", "".join(_aligned(half) for half in halves)


def _half_width(value: float, interval: Mapping[str, Any] | None) -> str:
    """The longer half of an interval, or that an end is open; nothing where the value is held."""
    if interval is None or interval["method"] == "held":
        return ""
    if None in (interval["low"], interval["high"]):
        return "open"
    return f"\u00b1 {digits(max(value - interval['low'], interval['high'] - value), _HALF)}"


def _extents(extents: Mapping[str, Any], unit: str | None) -> list[Row]:
    """All but what the headline has."""
    area = f"{large(extents['area'], unit)}, {part(round(extents['coverage'], 2))} of it near points"
    return [*EXTENTS[extents["kind"]].words(extents, unit)[1:], ("area", area)]


def _distances(error: Mapping[str, float], unit: str | None) -> Row:
    """Of all points."""
    every = ", ".join(f"{name} {digits(error[key])}" for name, key in _LENGTHS)
    return "distances", with_unit(every, unit)


def _error(error: Mapping[str, float], unit: str | None) -> list[Row]:
    share = f"mean {digits(error['relative_mean'])} of the diagonal of the bounding box"
    return [_distances(error, unit), ("", share)]


def _noise(noise: Mapping[str, Any] | None, unit: str | None) -> list[Row]:
    """Of the points; nothing where it is not known."""
    if noise is None:
        return []
    step = noise["quantisation_step"]
    said = [figure(noise["scale"], unit)]
    said += [f"coordinates in steps of {with_unit(f'{step:g}', unit)}"] if step else []
    shares = {"on it exactly": noise["exact_share"], "outliers": noise["outlier_share"]}
    told = ", ".join(f"{part(round(share, 3))} {name}" for name, share in shares.items() if share)
    return [
        *([("points", told)] if told else []),
        ("noise", ", ".join(said)),
        *(("", text) for text in _deviations(noise, unit)),
    ]


def _deviations(noise: Mapping[str, Any], unit: str | None) -> Iterator[str]:
    """What neighboring points have in common, in words."""
    for name, said in _SHARED.items():
        if (found := noise[name]) is not None:
            yield f"{said} {figure(found['size'], unit)} over {figure(found['range'], unit)}"


_SHARED = {
    "correlated": "neighboring points share a deviation of",
    "smooth": "the points deviate smoothly by",
}

_LENGTHS = (("rms", "rms"), ("mean", "mean"), ("95%", "p95"), ("max", "max"))


def _known_to(value: float, interval: Mapping[str, Any] | None) -> str:
    """With two digits of its standard deviation, far from the origin too, as long as a column holds them."""
    deviation = 0.0 if interval is None else interval["standard_deviation"]
    if not value or not deviation:
        return f"{value:.9g}"
    n_digits = math.floor(math.log10(abs(value))) - math.floor(math.log10(deviation)) + 2
    fitting = (f"{value:.{n}g}" for n in range(min(n_digits, 17), 9, -1))
    return next((text for text in fitting if len(text) < _COLUMN), f"{value:.9g}")


def _aligned(text: str) -> str:
    return f"{text:>{_COLUMN}}"
