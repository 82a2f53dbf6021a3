"""The files about all clouds of a batch: an assembly, a table, a report."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from primfit.fitting.errors import InvalidOptionError

from .batch import Gather
from .identity import identity
from .plan import Plan
from .status import BAD_INPUT, complain, refused

if TYPE_CHECKING:
    from ..exports.many import Part

FLAGS = {"step": "--step", "csv": "--table", "report": "--report"}


@dataclass(frozen=True)
class Gathered:
    """Where each of the files goes that are wanted, by what it is."""

    files: Mapping[str, Path]

    @property
    def gather(self) -> Gather | None:
        """What the run is to gather of each answer; None for nothing."""
        return Gather("report" in self.files) if self.files else None

    def check(self, plan: Plan, include: Collection[str]) -> None:
        """End with a complaint about what cannot be written, or would overwrite an input or another file."""
        if not self.files:
            return
        from ..exports import check_parts

        try:
            check_parts([name for name in self.files if name == "step"], include)
        except InvalidOptionError as error:
            raise refused("--include", str(error)) from None
        sources = {identity(name) for name in plan.targets.values()} - {None}
        taken = {target.resolve() for target in plan.targets}
        for name, file in self.files.items():
            if identity(file) in sources:
                raise refused(FLAGS[name], f"it would overwrite the input {file}")
            if file.resolve() in taken:
                raise refused(FLAGS[name], f"something else is written to {file}, too")
            taken.add(file.resolve())

    def write(self, parts: "Sequence[Part]") -> list[int]:
        """Write all of them; the exit status of each."""
        return [self._write(name, file, parts) for name, file in self.files.items()]

    def _write(self, name: str, file: Path, parts: "Sequence[Part]") -> int:
        from ..exports import ExportOptions, NothingToExportError
        from ..exports.many import write_many

        try:
            file.write_bytes(write_many(parts, name, ExportOptions()))
        except (NothingToExportError, InvalidOptionError) as error:
            complain(str(file), f"not written: {error}")
        except OSError as error:
            complain(str(file), f"cannot be written: {error.strerror or error}")
        else:
            return 0
        return BAD_INPUT
