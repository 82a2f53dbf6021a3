"""Segments of real scans: a folder with a file of points each and what object they were taken from.

`manifest.csv` has a header and a line a segment; the columns `file` and `kind` are read, others may stand
beside. A file is a NumPy array of shape (N, 3). Of the truth the kind alone is known: a floor is a plane, the
side of a can a cylinder. Segments are read where they are and copied nowhere.
"""

import csv
import zlib
from pathlib import Path

import numpy as np

from primfit.synthetic.recipes import KINDS

from .cases import Buckets, Case, Description, bucket

REAL = "real"
"""The name of the set that a folder makes."""

MANIFEST = "manifest.csv"

POINTS: Buckets = ((1000, "up to 1,000"), (10_000, "1,000 to 10,000"), (np.inf, "over 10,000"))

DESCRIPTION = Description(
    "Segments of real scans",
    "Segments of public scans, each of one primitive by what the object is, with the noise, density and "
    "border of their sensors. Only the kind is known, so there are no errors against the truth. A segment "
    "whose kind stands first or further back in an `ambiguous` answer is counted apart.",
    {"points": tuple(name for _, name in POINTS)},
)


class RealError(ValueError):
    """A manifest that lacks a column, or names an unknown kind or a file that cannot be read."""


class RealFolder:
    """The segments of a folder in the order of its manifest; points are read when they are asked for.

    Raises
    ------
    RealError : the manifest cannot be used
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        with (folder / MANIFEST).open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        try:
            self.kinds = {row["file"]: row["kind"] for row in rows}
        except KeyError as missing:
            raise RealError(f"{folder / MANIFEST} has no column {missing}") from None
        unknown = sorted(set(self.kinds.values()) - set(KINDS))
        if unknown or not self.kinds:
            raise RealError(f"{folder / MANIFEST} names {unknown or 'no segments'}, not {', '.join(KINDS)}")

    @property
    def names(self) -> list[str]:
        return list(self.kinds)

    @property
    def fingerprint(self) -> int:
        """Another number for a folder with other segments or kinds."""
        return zlib.crc32(repr(list(self.kinds.items())).encode())

    def case(self, name: str) -> Case:
        """Raises `RealError` for a file that holds no points."""
        try:
            points = np.asarray(np.load(self.folder / name, allow_pickle=False), np.float64)
        except (OSError, ValueError) as error:
            raise RealError(f"{self.folder / name} cannot be read: {error}") from None
        if points.ndim != 2 or points.shape[1] != 3:
            raise RealError(f"{self.folder / name} has the shape {points.shape}, not (N, 3)")
        return Case(name, points, None, {"points": bucket(POINTS, len(points))}, known_kind=self.kinds[name])


def is_there(folder: Path) -> bool:
    return (folder / MANIFEST).is_file()
