"""The answer as one row of a table, and as a prediction of the SHREC 2022 track."""

import csv as csv_rows
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from io import StringIO
from typing import Any

from primfit.fitting.answer.values import NoiseSummary
from primfit.fitting.primitives import parameters
from primfit.fitting.shrec22 import LAYOUT

from ..engine.shrec22 import prediction
from .fitted import Fitted, NothingToExportError
from .options import ExportOptions


def csv(fitted: Fitted, options: ExportOptions) -> bytes:
    """A header and a row: status, kind, parameters, unit, error and noise; vectors as three columns."""
    row = row_of(fitted)
    return table([row], list(row))


def table(rows: Iterable[Mapping[str, Any]], columns: Sequence[str]) -> bytes:
    """Rows under a header; what a row lacks is empty."""
    stream = StringIO()
    writer = csv_rows.DictWriter(stream, columns)
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue().encode()


def row_of(fitted: Fitted) -> dict[str, Any]:
    """The cells of an answer by the names of their columns."""
    primitive, recognition = fitted.primitive, fitted.recognition
    assert recognition.error and recognition.noise
    row: dict[str, Any] = {"status": recognition.status}
    for name, value in parameters(primitive).items():
        if isinstance(value, list):
            row |= {f"{name}_{along}": number for along, number in zip("xyz", value, strict=True)}
        else:
            row[name] = value
    row["unit"] = recognition.unit
    row |= asdict(recognition.error)
    return row | _noise(recognition.noise)


def _noise(noise: NoiseSummary) -> dict[str, float | None]:
    """A column for each number; the size and the range of a deviation that was not found are empty."""
    columns: dict[str, float | None] = {}
    for name, value in asdict(noise).items():
        if name in ("correlated", "smooth"):
            columns |= {f"noise_{name}_{of}": value and value[of] for of in ("size", "range")}
        else:
            columns[f"noise_{name}"] = value
    return columns


def shrec22(fitted: Fitted, options: ExportOptions) -> bytes:
    """The label and the parameters, one number a line; raises `NothingToExportError` for other kinds."""
    if fitted.primitive.kind not in LAYOUT:
        raise NothingToExportError(f"the SHREC 2022 track has no {fitted.primitive.kind}")
    return prediction(parameters(fitted.primitive)).encode()
