"""The report: from records to benchmark.md and its pictures; nothing is measured here."""

from collections.abc import Iterable
from pathlib import Path

from ..methods import PAPER, PUBLISHED
from ..proofs.records import ProofsFile
from ..records import RecordsFile
from . import pictures, sections, six
from .bars import held_to
from .data import OURS, Data, NoRecordsError
from .details import details
from .pictures import MissingMatplotlibError
from .proofs import proven
from .scans import FIRST, first

__all__ = ["MissingMatplotlibError", "NoRecordsError", "write"]


def write(file: RecordsFile, out: Path) -> Path:
    """Write benchmark.md, benchmark-details.md and images/benchmark-*.png into a folder; returns the first.

    The paper's six methods have pages of their own where there are records of any: benchmark-six.md and
    benchmark-six-details.md.

    Raises
    ------
    NoRecordsError : there is nothing to report
    MissingMatplotlibError : before anything is written
    """
    pictures.require_matplotlib()
    everything = Data.of(file)
    paper = everything.only((OURS, *PAPER, *PUBLISHED))
    data = everything.only([method for method in everything.methods if method not in PAPER])
    images = out / "images"
    drawn = pictures.draw(data, images, pictures.PICTURES) | pictures.draw(paper, images, six.PICTURES)
    parts: list[Iterable[str]] = [sections.head(data)]
    parts += [first(data, set_) for set_ in FIRST if set_ in data.sets]
    parts += [held_to(data)]
    parts += [proven(ProofsFile(file.path.parent).read())]
    parts += [sections.at_a_glance(data, drawn), sections.behind(data)]
    parts += [sections.of_set(data, set_, drawn) for set_ in data.sets if set_ not in FIRST]
    parts += [six.section(paper)]
    parts += [sections.methods(data), [sections.MEASURES]]
    _write(out / "benchmark-details.md", [details(data, "benchmark.md")])
    if six.run(paper):
        _write(out / "benchmark-six.md", [six.page(paper, drawn), sections.methods(paper)])
        _write(out / "benchmark-six-details.md", [details(paper, "benchmark-six.md")])
    return _write(out / "benchmark.md", parts)


def _write(path: Path, parts: Iterable[Iterable[str]]) -> Path:
    texts = ["\n".join(part).rstrip() for part in parts]
    path.write_text("\n\n".join(text for text in texts if text) + "\n")
    return path
