"""Rows as aligned lines for people."""

from collections.abc import Sequence
from typing import Any

_DIGITS = 6


def as_text(names: Sequence[str], rows: Sequence[Sequence[Any]], most: int | None = None) -> str:
    """A header and a line a row, numbers at the right; of more than `most` rows the others are left out."""
    shown = [[_cell(value) for value in row] for row in rows[:most]]
    numeric = [
        bool(rows) and all(isinstance(row[i], int | float | None) for row in rows) for i in range(len(names))
    ]
    widths = [max(map(len, column)) for column in zip(names, *shown, strict=True)]
    lines = [
        "  ".join(
            cell.rjust(width) if right else cell.ljust(width)
            for cell, width, right in zip(row, widths, numeric, strict=True)
        ).rstrip()
        for row in (list(names), *shown)
    ]
    if len(shown) < len(rows):
        lines.append(f"(the first {len(shown)}; --limit shows more)")
    return "\n".join(lines) + "\n"


def _cell(value: Any) -> str:
    """A value in few digits; names from files may hold what would move a terminal's cursor."""
    if value is None:
        return "-"
    text = f"{value:.{_DIGITS}g}" if isinstance(value, float) else str(value)
    return "".join(letter if letter.isprintable() else "?" for letter in text)
