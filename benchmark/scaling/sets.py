"""Segments of a virtual scanner as Parquet files, a row a segment: sets of which the smaller ones are the
beginning of the larger ones."""

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from primfit.synthetic import ScannerRecipe, clouds
from primfit.synthetic.recipes import Range

PER_FILE = 250
"""Segments of a file: some megabytes, read in one piece."""

RECIPE = ScannerRecipe(points=Range(50, 3000), decidable=False)
"""Log-uniform numbers of points. Kinds that the noise hides are left as they are: nobody asks which one is
right here, and it is twice as fast."""


@dataclass(frozen=True)
class SegmentSet:
    """The first `n` segments of a seed, in files under a folder."""

    folder: Path
    seed: int
    n: int

    @property
    def files(self) -> list[Path]:
        """In the order of their segments."""
        where = self.folder / f"seed-{self.seed}"
        return [where / f"{number:05}.parquet" for number in range(self.n // PER_FILE)]

    @property
    def missing(self) -> list[Path]:
        """Files that are not drawn yet."""
        return [file for file in self.files if not file.exists()]

    def draw(self, processes: int) -> Iterator[Path]:
        """Draw what is missing; a file is there whole or not at all."""
        missing = self.missing
        if missing:
            missing[0].parent.mkdir(parents=True, exist_ok=True)
        with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
            yield from pool.map(partial(_write, self.seed), missing)

    def listed(self) -> Path:
        """A list of its files, as `primfit batch @LIST` takes it; raises `FileNotFoundError`."""
        if self.missing:
            raise FileNotFoundError(
                f"{len(self.missing)} of {len(self.files)} files of segments are not there; "
                f"first: primfit bench scaling segments --n {self.n} --seed {self.seed}"
            )
        list_ = self.files[0].parent / f"first-{self.n}.txt"
        list_.write_text("".join(f"{file.absolute()}\n" for file in self.files))
        return list_

    def ids(self) -> Iterator[str]:
        """The ids that rows have, in their order."""
        for number, file in enumerate(self.files):
            for index in range(number * PER_FILE, (number + 1) * PER_FILE):
                yield f"{file.absolute()}#{index}"

    def lengths(self) -> list[int]:
        """The numbers of points of the segments."""
        import pyarrow.compute
        import pyarrow.parquet

        columns = (pyarrow.parquet.read_table(str(file), columns=["points"])["points"] for file in self.files)
        return [n for each in columns for n in pyarrow.compute.list_value_length(each).to_pylist()]


def _write(seed: int, file: Path) -> Path:
    start = int(file.stem) * PER_FILE
    drawn = [cloud.points for cloud in clouds(replace(RECIPE, seed=seed), PER_FILE, start)]
    return write_rows(file, start, drawn)


def write_rows(file: Path, start: int, segments: Sequence[Any]) -> Path:
    """Write segments, with ids from `start` on, as rows of Parquet; whole or not at all."""
    import pyarrow
    import pyarrow.parquet

    ids = pyarrow.array(range(start, start + len(segments)))
    table = pyarrow.table({"id": ids, "points": _lists(segments)})
    part = file.with_suffix(f".{os.getpid()}.part")
    pyarrow.parquet.write_table(table, str(part), compression="none", use_dictionary=False)
    os.replace(part, file)
    return file


def _lists(clouds: Sequence[Any]) -> Any:
    """A column of lists of points."""
    import pyarrow

    numbers = pyarrow.array(np.concatenate(clouds).ravel())
    offsets = pyarrow.array(np.cumsum([0, *map(len, clouds)]), pyarrow.int32())
    return pyarrow.ListArray.from_arrays(offsets, pyarrow.FixedSizeListArray.from_arrays(numbers, 3))
