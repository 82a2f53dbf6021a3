"""Many answers as one table."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from primfit.fitting.names import KINDS
from primfit.fitting.primitives import names_of

from ..fitted import Fitted
from ..options import ExportOptions
from ..text import row_of, table
from .part import Part


def table_of(parts: Sequence[Part], options: ExportOptions) -> bytes:
    """CSV with a row for each; parameters that a kind has not are empty, and so is what a problem has not."""
    rows = [_row(part) for part in parts]
    return table(rows, _columns(rows))


def _row(part: Part) -> dict[str, Any]:
    row = {**part.where, "status": part.status}
    found = part.recognition
    if found is not None:
        row["n_points"] = found.n_points
        if found.primitive is not None:
            row |= row_of(Fitted(found))
    return row | {"message": part.message}


def _columns(rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """All columns that a row has: parameters in the order of the kinds behind the kind, the message last."""
    there = dict.fromkeys(name for row in rows for name in row)
    numbers = dict.fromkeys(name.replace(".", "_") for kind in KINDS for name in names_of(kind))
    first = [name for name in there if name not in numbers and name != "message"]
    behind = first.index("kind") + 1 if "kind" in first else len(first)
    parameters = [name for name in numbers if name in there]
    return [*first[:behind], *parameters, *first[behind:], "message"]
