"""The report: from records to benchmark.md and its pictures; nothing is measured here."""

from collections.abc import Iterable
from pathlib import Path

from ..proofs.records import ProofsFile
from ..records import RecordsFile
from . import pictures, sections, six
from .bars import held_to
from .data import Data, NoRecordsError
from .details import details
from .pictures import MissingMatplotlibError
from .proofs import proven
from .scans import FIRST, first

__all__ = ["MissingMatplotlibError", "NoRecordsError", "write"]


def write(file: RecordsFile, out: Path) -> Path:
    """Write benchmark.md, benchmark-details.md and images/benchmark-*.png into a folder; returns the first.

    Raises
    ------
    NoRecordsError : there is nothing to report
    MissingMatplotlibError : before anything is written
    """
    pictures.require_matplotlib()
    data = Data.of(file)
    drawn = pictures.draw(data, out / "images", pictures.PICTURES | six.PICTURES)
    parts: list[Iterable[str]] = [sections.head(data)]
    parts += [first(data, set_) for set_ in FIRST if set_ in data.sets]
    parts += [held_to(data)]
    parts += [proven(ProofsFile(file.path.parent).read())]
    parts += [sections.at_a_glance(data, drawn), sections.behind(data)]
    parts += [sections.of_set(data, set_, drawn) for set_ in data.sets if set_ not in FIRST]
    parts += [six.section(data, drawn)]
    parts += [sections.methods(data), [sections.MEASURES]]
    _write(out / "benchmark-details.md", [details(data)])
    return _write(out / "benchmark.md", parts)


def _write(path: Path, parts: Iterable[Iterable[str]]) -> Path:
    texts = ["\n".join(part).rstrip() for part in parts]
    path.write_text("\n\n".join(text for text in texts if text) + "\n")
    return path
