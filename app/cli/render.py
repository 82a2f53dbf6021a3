"""An answer for people: the primitive, its error and the trail of attempts, on a terminal."""

from collections.abc import Mapping
from typing import Any

from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from primfit.fitting.answer.summary import headline, sections
from primfit.fitting.extents.values import Row
from primfit.fitting.plain import worded
from primfit.fitting.words import digits

COLOR = {
    "fitted": "green",
    "ambiguous": "yellow",
    "no_fit": "red",
    "accepted": "green",
    "refused": "yellow",
    "failed": "red",
}
STATUSES = tuple(map(worded, ("fitted", "ambiguous", "no_fit")))
LABEL_STYLE = {"warning": "yellow"}
TEXT_STYLE = {"kind": "bold", "best try": "bold", "or": "bold"}


UNWRAPPED = 10_000
"""Characters of a line that is not wrapped."""


def show(name: str, body: Mapping[str, Any]) -> None:
    """Print the answer of one file; into a pipe or a file no line is wrapped, and none ends in blanks."""
    console = Console(highlight=False)
    if console.is_terminal:
        console.print(render(name, body))
        return
    console.width = UNWRAPPED
    with console.capture() as captured:
        console.print(render(name, body))
    print("\n".join(line.rstrip() for line in captured.get().splitlines()), flush=True)


def render(name: str, body: Mapping[str, Any]) -> RenderableType:
    """The answer of one file (the body of `POST /fit`) as a rich renderable."""
    status, first = body["status"], headline(body)
    verdict = [(worded(status), body["message"])]
    lead = [verdict, first] if status == "no_fit" else [first, verdict]
    title = Text.assemble(("── ", "dim"), (name, "bold"))
    parts: list[RenderableType] = [title, Padding(_read(body["receipt"]), (0, 0, 1, 0))]
    parts += [Padding(_grid(rows, COLOR[status]), (0, 0, 1, 0)) for rows in [*lead, *sections(body)] if rows]
    parts.append(Padding(_attempts(body["attempts"]), (0, 0, 1, 0)))
    said = body["message"]
    reasons = [(each["kind"], each["reason"]) for each in body["attempts"] if each["reason"] not in said]
    if reasons:
        parts.append(Padding(_grid(reasons, ""), (0, 0, 1, 0)))
    return Group(*parts)


def _read(receipt: Mapping[str, Any]) -> Text:
    """What was read; in a line of its own, as a long name leaves the title no room."""
    unit = f"in {receipt['unit']}" if receipt.get("unit") else "unit not given"
    columns = " ".join(receipt["columns"])
    return Text(f"{receipt['n_points']:,} points, {receipt['format']} {columns}, {unit}", "dim")


def _grid(rows: list[Row], color: str) -> Table:
    grid = Table.grid(padding=(0, 2, 0, 0), pad_edge=True)
    grid.add_column(style="dim", no_wrap=True, min_width=15)
    for label, text in rows:
        style = f"bold {color}" if label in STATUSES else LABEL_STYLE.get(label, "")
        grid.add_row(Text(label, style), Text(text, TEXT_STYLE.get(label, "")))
    return grid


def _attempts(attempts: list[Mapping[str, Any]]) -> Table:
    table = Table(box=None, header_style="dim", padding=(0, 2, 0, 0), pad_edge=False)
    table.add_column("tried", no_wrap=True, min_width=15)
    for title in ("rank", "evidence", "mean distance"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("outcome", no_wrap=True)
    for attempt in attempts:
        probability, evidence, error = attempt["probability"], attempt["evidence"], attempt["error"]
        outcome = attempt["outcome"]
        table.add_row(
            attempt["kind"],
            "-" if probability is None else f"{probability:.3f}",
            "-" if evidence is None else f"{evidence:z.1f}",
            "-" if error is None else digits(error["mean"]),
            Text(outcome, COLOR[outcome]),
        )
    return table
