"""The page: where primfit is not ahead, what was measured on each set, and what differs from the paper."""

from collections.abc import Collection, Iterator

from ...measures import GRID
from ...methods import PAPER
from ...real import REAL
from ...track import TRACK
from ..data import Data
from ..markdown import commands
from . import tables
from .ahead import COMPARED, not_ahead
from .differences import differences
from .pictures import LEAST

PARTS = {
    tables.BESIDE: "On clouds like those of the paper",
    TRACK: "On clouds of the track itself",
    "sensor": "On clouds as sensors make them",
    REAL: "On segments of real scans",
}
"""The sets that are shown, and the titles of their parts."""

ABOUT = {
    tables.BESIDE: (
        "Other clouds than the paper's, of the same laws. Its figures are those of its tables 1 and 2, of "
        "the methods as their own authors made them. In the pictures rates do not begin at 0; the shortest "
        f"bars of errors are those below {LEAST:g}."
    ),
    TRACK: (
        "*m4-published* are the answers of M4 that its authors published for these clouds, read from the "
        "folder. How long they took is not known."
    ),
    "sensor": "The paper did not try such clouds, and no method was made for them.",
    REAL: "The paper tried no real scans. Only the kind is known, so there is no L2.",
}

PICTURES = {
    tables.BESIDE: {
        "six-confusion": "Confusion matrices, as in the paper's figure 8",
        "six-rates": "Macro averages by method and perturbation, as in the paper's figure 9",
        "six-errors": "Mean errors of right answers by method and perturbation, as in the paper's figure 10",
    },
    "sensor": {"six-sensor": "Confusion matrices on clouds as sensors make them"},
    REAL: {"six-real": "Confusion matrices on segments of real scans"},
}
"""The pictures that stand with a set, and what they show."""


GROUPS = ("perturbation", "sensor", "points")
"""What results are shown by."""


def run(data: Data) -> list[str]:
    """Those of the six of which there are records."""
    return [method for method in data.methods if method in PAPER]


def section(data: Data) -> Iterator[str]:
    """The section of benchmark.md; nothing where there are no records of any of the six."""
    if not run(data):
        return
    yield "## The six methods"
    yield ""
    yield from not_ahead(data)
    yield ""
    yield (
        f"{COMPARED} [benchmark-six.md](benchmark-six.md) has the figures of the methods M1 to M6 of the "
        "SHREC 2022 paper, made again from its text, beside those of the paper and of primfit."
    )


def page(data: Data, drawn: Collection[str]) -> Iterator[str]:
    """All of benchmark-six.md but the table of methods."""
    yield "# The six methods of the paper, beside primfit"
    yield ""
    yield "<!-- Written by `primfit bench report`; change benchmark/report/six/, not this file. -->"
    yield ""
    yield from not_ahead(data)
    yield ""
    yield COMPARED
    yield ""
    yield (
        "The methods M1 to M6 of the SHREC 2022 paper, [made again from its text](paper.md), beside primfit."
        + _missing(run(data))
        + " In the quartiles a wrong answer is infinitely far; mean and standard deviation are those of the "
        f"right ones. Distances to a sampled surface are those to {GRID} x {GRID} samples, so that they are "
        "not 0 for the true surface either (*truth*). [benchmark-six-details.md](benchmark-six-details.md) "
        "has every class, and all rates, quartiles and times by perturbation and size."
    )
    for set_, title in PARTS.items():
        if any(method in PAPER for method in tables.shown(data, set_)):
            yield ""
            yield from _part(data, set_, title, drawn)
    yield ""
    yield from differences(run(data))


def _missing(known: Collection[str]) -> str:
    left = [method for method in PAPER if method not in known]
    return f" There are no records of {', '.join(left)}." if left else ""


def _part(data: Data, set_: str, title: str, drawn: Collection[str]) -> Iterator[str]:
    yield f"## {title}"
    yield ""
    if set_ != TRACK or "m4-published" in data.methods:
        yield ABOUT[set_]
        yield ""
    for name, shows in PICTURES.get(set_, {}).items():
        if name in drawn:
            yield f"![{shows}](images/benchmark-{name}.png)"
            yield ""
    yield from tables.kinds(data, set_)
    yield ""
    yield from tables.errors(data, set_)
    if set_ == TRACK:
        yield ""
        yield "L2 on each cloud:"
        yield ""
        yield from tables.by_cloud(data, set_)
    for group in () if set_ == TRACK else data.groups(set_):
        if group in GROUPS:
            yield ""
            yield f"By {group}:"
            yield ""
            yield from tables.by_group(data, set_, group)
    yield ""
    yield from commands([*data.commands([set_]), "primfit bench report"])
