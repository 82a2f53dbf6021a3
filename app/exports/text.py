"""The answer as one row of a table, and as a prediction of the SHREC 2022 track."""

import csv as rows
from dataclasses import asdict
from io import StringIO
from typing import Any

from app.exports.options import ExportOptions
from app.exports.patch import NothingToExportError
from app.shrec22 import prediction
from fitting.primitives import parameters
from fitting.result import Recognition


def csv(recognition: Recognition, options: ExportOptions) -> bytes:
    """A header and a row: status, kind, parameters, error and noise; vectors as three columns."""
    if recognition.error is None or recognition.noise is None:
        raise NothingToExportError(f"the answer is {recognition.status} and holds no primitive to export")
    row: dict[str, Any] = {"status": recognition.status}
    for name, value in _parameters(recognition).items():
        if isinstance(value, list):
            row |= {f"{name}_{along}": number for along, number in zip("xyz", value, strict=True)}
        else:
            row[name] = value
    row |= asdict(recognition.error)
    row |= {f"noise_{name}": value for name, value in asdict(recognition.noise).items()}
    stream = StringIO()
    writer = rows.DictWriter(stream, list(row))
    writer.writeheader()
    writer.writerow(row)
    return stream.getvalue().encode()


def shrec22(recognition: Recognition, options: ExportOptions) -> bytes:
    """The label and the parameters, one number a line."""
    return prediction(_parameters(recognition)).encode()


def _parameters(recognition: Recognition) -> dict[str, Any]:
    if recognition.primitive is None:
        raise NothingToExportError(f"the answer is {recognition.status} and holds no primitive to export")
    return dict(parameters(recognition.primitive))
