"""One HTML page about many answers: a table of all, and sections about the first of them."""

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from primfit.fitting.plain import worded
from primfit.fitting.primitives import SIZES, is_angle
from primfit.fitting.words import with_unit

from ..options import ExportOptions
from ..report.markup import Markup, element, joined, table
from ..report.svg import PICTURE_STYLE
from .part import PICTURED, Part

_STYLE = Path(__file__).parents[1] / "report" / "style.css"
SHOWN = ("fitted", "ambiguous", "no_fit", "problem")
_NUMBERS = ("rms of the inliers", "inliers", "points")
_OWN_STYLE = Markup("""
.part { display: grid; grid-template-columns: minmax(0, 1fr) minmax(0, 2fr); gap: 0 1.5rem; }
.part figure { align-self: start; }
.part pre { margin: 0; font-size: 0.8rem; white-space: pre-wrap; }
body > table td:last-child, body > .wide td:last-child { min-width: 16rem; }
@media (max-width: 44rem) { .part { grid-template-columns: 1fr; } }
""")
_CLASSES = {"problem": "failed"}


def overview(parts: Sequence[Part], options: ExportOptions) -> bytes:
    """The page in UTF-8; the same answers give the same bytes."""
    title = f"{len(parts):,} {'cloud' if len(parts) == 1 else 'clouds'}"
    counts = Counter(part.status for part in parts)
    told = ", ".join(f"{counts[status]:,} {worded(status)}" for status in SHOWN if counts[status])
    header = element("header", element("h1", title), element("p", told))
    rows = (_row(part, number, options.unit) for number, part in enumerate(parts))
    numbers = (element("th", title, class_="number", scope="col") for title in _NUMBERS)
    columns = ("", "status", "kind", "size", *numbers, "")
    unit = options.unit or "that of the input, which is not given"
    foot = element("footer", f"Made by primfit. Unit of lengths: {unit}.")
    body = element("body", header, table(rows, columns), *_sections(parts), foot)
    return f'<!doctype html>\n<html lang="en"><head>{_head(title)}</head>{body}</html>\n'.encode()


def _head(title: str) -> Markup:
    return joined(
        [
            Markup('<meta charset="utf-8">'),
            Markup('<meta name="viewport" content="width=device-width, initial-scale=1">'),
            element("title", title),
            element("style", PICTURE_STYLE, Markup(_STYLE.read_text(encoding="utf-8")), _OWN_STYLE),
        ]
    )


def _row(part: Part, number: int, unit: str | None) -> Iterator[object]:
    """A link to its section where it has one, and what people look for first."""
    is_shown = number < PICTURED and part.recognition is not None
    yield element("a", part.name, href=f"#part-{number}") if is_shown else part.name
    yield element("td", element("span", worded(part.status), class_=_CLASSES.get(part.status, part.status)))
    found = part.recognition
    if found is None or found.primitive is None or found.error is None:
        yield from ("-", "-", *map(_number, "--"))
    else:
        yield found.primitive.kind
        yield _sizes(found.primitive, unit)
        yield _number(with_unit(f"{found.error.inlier_rms:.4g}", unit))
        yield _number(f"{found.error.inlier_share:.1%}")
    yield _number("-" if found is None else f"{found.n_points:,}")
    yield part.message


def _number(content: str) -> Markup:
    return element("td", content, class_="number")


def _sizes(primitive: object, unit: str | None) -> str:
    """Its radii and angles in words."""
    sizes = ((name, getattr(primitive, name, None)) for name in SIZES)
    return ", ".join(
        f"{worded(name)} "
        + (f"{np.degrees(value):.6g}\u00b0" if is_angle(name) else with_unit(f"{value:.6g}", unit))
        for name, value in sizes
        if value is not None
    )


def _sections(parts: Sequence[Part]) -> Iterator[Markup]:
    if len(parts) > PICTURED:
        told = f"The first {PICTURED} are shown below; the table has all of them."
        yield element("p", told, class_="note")
    for number, part in enumerate(parts[:PICTURED]):
        if part.recognition is not None:
            shown = [element("figure", Markup(part.picture))] if part.picture else []
            words = element("div", element("pre", str(part.recognition)), class_="wide")
            title = element("h2", part.name, id=f"part-{number}")
            yield element("section", title, element("div", *shown, words, class_="part"))
