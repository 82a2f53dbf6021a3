"""HTML and SVG of which every text is escaped, unless it is markup already."""

from collections.abc import Iterable
from html import escape


class Markup(str):
    """Text that is markup: made by `element`, or written in this package."""


def element(tag: str, *children: object, **attributes: object) -> Markup:
    """`<tag attributes>children</tag>`; `class_` is `class`, and `stroke_width` is `stroke-width`.

    Children that are no `Markup` are escaped, and so are the values of attributes.
    """
    written = "".join(
        f' {name.rstrip("_").replace("_", "-")}="{escape(str(value))}"' for name, value in attributes.items()
    )
    return Markup(f"<{tag}{written}>{joined(children)}</{tag}>")


def joined(children: Iterable[object]) -> Markup:
    """Children one after the other, escaped where they are no markup."""
    return Markup("".join(c if isinstance(c, Markup) else escape(str(c)) for c in children))


def table(rows: Iterable[Iterable[object]], header: Iterable[object] = (), **attributes: object) -> Markup:
    """A table; a cell that is a `td` or `th` stands as it is, the first other one of a row is its head."""
    head = joined(title if _is_cell(title) else element("th", title, scope="col") for title in header)
    body = joined(element("tr", *_cells(row)) for row in rows)
    parts = [element("thead", element("tr", head))] if head else []
    return element("div", element("table", *parts, element("tbody", body), **attributes), class_="wide")


def _cells(row: Iterable[object]) -> Iterable[object]:
    for i, cell in enumerate(row):
        yield cell if _is_cell(cell) else element("td", cell) if i else element("th", cell, scope="row")


def _is_cell(content: object) -> bool:
    return isinstance(content, Markup) and content.startswith(("<td", "<th"))
