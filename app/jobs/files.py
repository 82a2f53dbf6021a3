"""The folder of the jobs: for each of them one with its body, and its results as far as they are.

Results stand in `N.ndjson`, N being the attempt that has written them: an attempt that has lost its lease
and does not know it yet writes where nobody looks. `N.index` says of each line where it ends and what it is
about. What counts is what the record of the job counts; what stands behind that is written again.
"""

import os
import shutil
import struct
import uuid
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import orjson

from ..engine import items
from ..wire.problems import JobsUnavailableError, room_needed
from ..workers.batch_jobs import Stretch
from .record import Part

OUTCOMES = ("fitted", "ambiguous", "no_fit", "problems")
_ENTRY = struct.Struct("<QIIIB")
"""Where a line ends; the file of the batch, the item of it, of how many; its outcome."""
_SUMMARY = (0, 0, 0, 255)
_BODY = "body"
_DISK = "jobs"

Line = tuple[items.Told | None, bytes]
"""A line with what it is about; the summary is about nothing."""


class WrongDatabaseError(JobsUnavailableError):
    """The database of the jobs is not that of their folder."""


class JobFiles:
    """The files of one job."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @property
    def body(self) -> Path:
        """The request body as it came."""
        return self.folder / _BODY

    def appender(self, attempt: int) -> "Appender":
        return Appender(self.folder, attempt)

    def remove_body(self) -> None:
        self.body.unlink(missing_ok=True)

    def are_lost(self, parts: Sequence[Part]) -> bool:
        """Whether the body or results are gone, while the folder of all jobs is there.

        Where that is not there either, its disk may come back.
        """
        needed = [self.body, *map(self._results, parts), *map(self._index_file, parts)]
        return self.folder.parent.is_dir() and not all(path.exists() for path in needed)

    def told(self, parts: Sequence[Part]) -> list[items.Told]:
        """What the lines so far are about, without the summary."""
        found = []
        for part in parts:
            with self._results(part).open("rb") as lines:
                for line, (_, *place) in zip(lines, _ENTRY.iter_unpack(self._index(part)), strict=False):
                    if tuple(place) != _SUMMARY:
                        file, index, of, outcome = place
                        label = orjson.loads(line)["label"]
                        found.append(items.Told(file, index, of, OUTCOMES[outcome], label))
        return found

    def page(self, parts: Sequence[Part], offset: int, limit: int) -> list[Stretch]:
        """Where the lines from `offset` on stand, at most `limit` of them."""
        stretches = []
        for part in parts:
            first, last = min(offset, part.lines), min(offset + limit, part.lines)
            if first < last:
                stretches.append(Stretch(self._results(part), self._end(part, first), self._end(part, last)))
            offset, limit = offset - first, limit - (last - first)
        return stretches

    def _end(self, part: Part, n_lines: int) -> int:
        """The length of the first lines of a part."""
        if n_lines == 0:
            return 0
        with self._index_file(part).open("rb") as file:
            file.seek((n_lines - 1) * _ENTRY.size)
            return int(_ENTRY.unpack(file.read(_ENTRY.size))[0])

    def _index(self, part: Part) -> bytes:
        with self._index_file(part).open("rb") as file:
            return file.read(part.lines * _ENTRY.size)

    def _index_file(self, part: Part) -> Path:
        return self.folder / f"{part.attempt}.index"

    def _results(self, part: Part) -> Path:
        return self.folder / f"{part.attempt}.ndjson"


class Appender:
    """Results of one attempt."""

    def __init__(self, folder: Path, attempt: int) -> None:
        self.part = Part(attempt, 0, 0)
        self._files = tuple(folder / f"{attempt}.{end}" for end in ("ndjson", "index"))

    def append(self, lines: Sequence[Line]) -> Part:
        """Write lines behind those there are, and wait until the disk holds them.

        Raises
        ------
        InsufficientStorageError
            The disk is full, or refuses; then it is as if nothing had been written.
        """
        content, index, end = b"".join(line for _, line in lines), b"", self.part.bytes
        for told, line in lines:
            end += len(line)
            place = _SUMMARY if told is None else (told.file, told.index, told.of)
            outcome = () if told is None else (OUTCOMES.index(told.outcome),)
            index += _ENTRY.pack(end, *place, *outcome)
        with room_needed(_DISK):
            _write_at(self._files[0], self.part.bytes, content)
            _write_at(self._files[1], self.part.lines * _ENTRY.size, index)
            if self.part.lines == 0:
                _sync(self._files[0].parent)
        self.part = Part(self.part.attempt, self.part.lines + len(lines), end)
        return self.part


class Folder:
    """The folder `jobs_path`, which several services may share."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._jobs = path / "jobs"
        # For nobody else: where there are no keys, whoever knows the id of a job may have it.
        self.path.mkdir(mode=0o700, parents=True, exist_ok=True)
        self._jobs.mkdir(mode=0o700, exist_ok=True)

    def belong(self, database: str, is_empty: bool) -> None:
        """Check that this is the folder of a database, which is noted when both are new.

        Parameters
        ----------
        database : its id, for ever
        is_empty : whether it has no record

        Raises
        ------
        WrongDatabaseError
            It is not: no record would be found, and the files of all jobs would seem to be nobody's.
        """
        note = self.path / "database"
        if not note.exists() and is_empty and not self.ids():
            _write_whole(note, database)
        if not note.exists() or note.read_text() != database:
            raise WrongDatabaseError(
                "jobs_path and jobs_database do not belong together: the folder is not the one that this "
                "database was used with (without jobs_database it is jobs.sqlite in jobs_path). "
                "Set both as they were, or let jobs_path name an empty folder and jobs_database an empty "
                "database"
            )

    def of(self, job_id: str) -> JobFiles:
        return JobFiles(self._jobs / job_id)

    def create(self, job_id: str, body: bytes | Path) -> None:
        """Keep the body of a new job; when this returns, the disk holds it.

        Raises
        ------
        InsufficientStorageError
            The disk is full, or refuses; then nothing of it stays.
        """
        files = self.of(job_id)
        try:
            with room_needed(_DISK):
                files.folder.mkdir(mode=0o700)
                with files.body.open("xb") as file:
                    if isinstance(body, bytes):
                        file.write(body)
                    else:
                        with body.open("rb") as source:
                            shutil.copyfileobj(source, file, 1 << 20)
                    file.flush()
                    os.fsync(file.fileno())
                _sync(files.folder)
                _sync(self._jobs)
        except BaseException:
            self.remove(job_id)
            raise

    def remove(self, job_id: str) -> None:
        """Everything of a job."""
        shutil.rmtree(self.of(job_id).folder, ignore_errors=True)

    def ids(self) -> set[str]:
        """The jobs of which there is something."""
        return set(os.listdir(self._jobs))


def _write_whole(path: Path, text: str) -> None:
    """A small file that appears whole, also where the disk knows no links."""
    unfinished = path.with_name(f"{path.name}.{uuid.uuid4()}")
    with room_needed(_DISK):
        try:
            with unfinished.open("x") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            unfinished.replace(path)
        finally:
            unfinished.unlink(missing_ok=True)
        _sync(path.parent)


def _write_at(path: Path, position: int, content: bytes) -> None:
    """Bytes at the end of a file, which is cut to `position` before, and again where they do not fit."""
    with open(path, "r+b" if path.exists() else "w+b", buffering=0) as file:
        file.truncate(position)
        file.seek(position)
        try:
            view = memoryview(content)
            while view:
                view = view[file.write(view) :]
            os.fsync(file.fileno())
        except OSError:
            with suppress(OSError):
                file.truncate(position)
            raise


def _sync(folder: Path) -> None:
    """Wait until the disk holds the names of a folder; systems that cannot open one keep them anyhow."""
    if os.name == "nt":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
