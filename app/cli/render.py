"""An answer for people: the primitive, its error and the trail of attempts, on a terminal."""

from collections.abc import Mapping
from typing import Any

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from primfit.fitting.answer.summary import Row, sections
from primfit.fitting.plain import worded

COLOR = {
    "fitted": "green",
    "ambiguous": "yellow",
    "no_fit": "red",
    "accepted": "green",
    "refused": "yellow",
    "failed": "red",
}
LABEL_STYLE = {"warning": "yellow"}
TEXT_STYLE = {"kind": "bold", "best try": "bold", "or": "bold"}


def render(name: str, body: Mapping[str, Any]) -> RenderableType:
    """The answer of one file (the body of `POST /fit`) as a rich renderable."""
    status = body["status"]
    receipt = body["receipt"]
    title = Text.assemble(
        (name, "bold"),
        f"  {receipt['n_points']:,} points, {receipt['format']} {' '.join(receipt['columns'])}",
    )
    found = Text.assemble((worded(status), f"bold {COLOR[status]}"), "  ", body["message"])
    parts: list[RenderableType] = [Text.assemble(("── ", "dim"), title), found]
    parts += [Padding(_grid(section), (1, 0, 0, 0)) for section in sections(body)]
    parts.append(Padding(_attempts(body["attempts"]), (1, 0, 1, 0)))
    return Group(*parts)


def _grid(rows: list[Row]) -> Table:
    grid = Table.grid(padding=(0, 2, 0, 0), pad_edge=True)
    grid.add_column(style="dim", no_wrap=True, min_width=12)
    for label, text in rows:
        grid.add_row(Text(label, LABEL_STYLE.get(label, "")), Text(text, TEXT_STYLE.get(label, "")))
    return grid


def _attempts(attempts: list[Mapping[str, Any]]) -> Table:
    table = Table(box=None, header_style="dim", padding=(0, 2, 0, 0), pad_edge=False)
    table.add_column("tried", no_wrap=True)
    table.add_column("rank", justify="right", no_wrap=True)
    table.add_column("evidence", justify="right", no_wrap=True)
    table.add_column("mean error", justify="right", no_wrap=True)
    table.add_column("outcome", no_wrap=True)
    table.add_column("why", ratio=1)
    for attempt in attempts:
        probability, evidence, error = attempt["probability"], attempt["evidence"], attempt["error"]
        outcome = attempt["outcome"]
        table.add_row(
            attempt["kind"],
            "-" if probability is None else f"{probability:.3f}",
            "-" if evidence is None else f"{evidence:z.1f}",
            "-" if error is None else f"{error['mean']:.3g}",
            Text(outcome, COLOR[outcome]),
            attempt["reason"],
        )
    return table
