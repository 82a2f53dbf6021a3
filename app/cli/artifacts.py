"""The files that are written beside an answer."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.names import ANSWER_PARTS

from ..exports import ExportOptions, Fitted, NothingToExportError, Outcome, check_parts, outcomes
from .identity import identity
from .status import BAD_INPUT, complain, refused, worst


@dataclass(frozen=True)
class Artifacts:
    """What is written of the answer for one file: where each format goes, and how."""

    files: dict[str, Path]
    options: ExportOptions

    @classmethod
    def wanted(
        cls,
        files: dict[str, Path | None],
        inputs: list[str],
        labels: str | None,
        how: Mapping[str, Any],
        include: Sequence[str] | None,
    ) -> Self | None:
        """What was asked for, if anything; refuses what cannot be exported before anything is fitted."""
        given = {format: file for format, file in files.items() if file is not None}
        if not given:
            return None
        if len(inputs) > 1 or labels:
            several = "the segments of a file" if labels else str(len(inputs))
            raise refused("fit", f"exports are written of one FILE, not of {several}")
        _check_overwriting(given, inputs[0])
        try:
            options = ExportOptions(**how)
            check_parts(given, ANSWER_PARTS if include is None else include)
            return cls(given, options)
        except InvalidOptionError as error:
            raise refused(f"--{error.field.replace('_', '-')}", str(error)) from None

    def write(self, fitted: Fitted) -> int:
        """Write all of them; the exit status."""
        try:
            found = outcomes(fitted, self.files, self.options)
        except (NothingToExportError, InvalidOptionError) as error:
            return worst([self._refuse(file, str(error)) for file in self.files.values()])
        return worst([self._write(self.files[format], each) for format, each in found.items()])

    def _write(self, file: Path, outcome: Outcome) -> int:
        if outcome.content is None:
            return self._refuse(file, outcome.problem)
        if outcome.warning:
            complain(str(file), outcome.warning)
        try:
            file.write_bytes(outcome.content)
        except OSError as error:
            complain(str(file), f"cannot be written: {error.strerror or error}")
            return BAD_INPUT
        return 0

    def _refuse(self, file: Path, why: str) -> int:
        complain(str(file), f"not written: {why}")
        return BAD_INPUT


def _check_overwriting(files: dict[str, Path], read: str) -> None:
    taken = {_known_by(read): "the input"}
    for format, file in files.items():
        known = _known_by(file)
        if known in taken:
            raise refused(str(file), f"the export {format} would overwrite {taken[known]}")
        taken[known] = f"the export {format}"


def _known_by(file: str | Path) -> tuple[int, int] | Path:
    """What the names of one file have in common; of one that is yet to be made its place."""
    return identity(file) or Path(file).resolve()
