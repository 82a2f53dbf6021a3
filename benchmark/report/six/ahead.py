"""Where primfit is not ahead of the paper's methods: six measures on each perturbation, and on other sets."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from primfit.synthetic.perturb import TYPES

from ...methods import PAPER
from ...real import REAL
from ...records import Record
from ...scores import EXACT, averages, confusion, grouped
from ...track import TRACK
from ..cells import median, rate_text
from ..data import OURS, Data, common
from ..markdown import scientific, table
from . import tables

SEGMENTS = "real segments"
PLACES: dict[str, Callable[[Record], str]] = {
    tables.BESIDE: lambda record: str(record.groups.get("perturbation")),
    "sensor": lambda record: "clouds of sensors",
    TRACK: lambda record: "clouds of the track",
    REAL: lambda record: SEGMENTS,
}
"""The sets that are compared, and where in the set a record counts."""
RATES = ("TPR", "TNR", "PPV", "NPV", "ACC")
MEASURES = (*RATES, "L2")


@dataclass(frozen=True)
class Comparison:
    """A measure of two methods on the same clouds: a macro rate, or the median of L2.

    `place` is a perturbation, or a whole set.
    """

    method: str
    place: str
    measure: str
    theirs: float
    ours: float

    @property
    def outcome(self) -> str:
        """Of primfit: ahead, behind, level, or perfect where both are and nobody can be ahead."""
        ours, theirs = (self._goodness(value) for value in (self.ours, self.theirs))
        if ours == theirs:
            return "perfect" if ours == self._goodness(0.0 if self.measure == "L2" else 1.0) else "level"
        return "ahead" if ours > theirs else "behind"

    def _goodness(self, value: float) -> float:
        """Below `EXACT` nobody is called more exact."""
        if self.measure == "L2":
            return -max(value, EXACT)
        return -np.inf if np.isnan(value) else value

    @property
    def text(self) -> str:
        """Theirs and ours."""
        shown = scientific if self.measure == "L2" else rate_text
        return f"{shown(self.theirs)} / {shown(self.ours)}"


def comparisons(data: Data) -> list[Comparison]:
    """Of primfit with each method of the paper, on the clouds that both were asked about."""
    return [one for method in PAPER for set_ in PLACES for one in _with(data, method, set_)]


def _with(data: Data, method: str, set_: str) -> Iterator[Comparison]:
    theirs, ours = (
        grouped(records, PLACES[set_])
        for records in common(data.of_set(set_, method), data.of_set(set_, OURS))
    )
    for place in sorted(theirs):
        figures = (_figures(records[place], set_) for records in (theirs, ours))
        for measure, their, our in zip(MEASURES, *figures, strict=False):
            yield Comparison(method, place, measure, their, our)


def _figures(records: Sequence[Record], set_: str) -> list[float]:
    """One for each of `MEASURES`, the last of which real segments do not have."""
    found = averages(confusion(records))
    lengths = [] if set_ == REAL else [median(records, tables.lengths_of(set_))]
    return [*(found[rate] for rate in RATES), *lengths]


WHERE = {
    "behind": "primfit is behind {}.",
    "level": "It is level with {}.",
    "perfect": "Both are perfect, so that nobody can be ahead: {}.",
}
"""How it is said where primfit is not ahead."""


COMPARED = (
    "A perturbation, and each other set, is compared as a whole; its parts stand further down. Rates are "
    "macro averages, PPV over the kinds that are there; L2 is the median, and below "
    f"{EXACT:g} it is perfect, however many kinds are wrong."
)
"""What stands below the paragraph and its table."""


def not_ahead(data: Data) -> Iterator[str]:
    """A paragraph, and a table where there is something to show."""
    made = comparisons(data)
    if not made:
        yield "Where primfit is not ahead is not known: no clouds have records of both."
        return
    by_outcome = grouped(made, lambda one: one.outcome)
    said = [text.format(_listing(by_outcome[name])) for name, text in WHERE.items() if name in by_outcome]
    if "behind" not in by_outcome and said:
        said.insert(0, "primfit is nowhere behind.")
    if "ahead" in by_outcome:
        said.append(f"{'Elsewhere it' if said else 'primfit'} is ahead {_everywhere(made)}.")
    yield " ".join(said)
    short = [*by_outcome.get("behind", []), *by_outcome.get("level", [])]
    if short:
        yield ""
        yield "Theirs / ours, where primfit is behind (bold) or level:"
        yield ""
        yield from _table(sorted(short, key=lambda one: (one.method, one.place)))


def _listing(made: Sequence[Comparison]) -> str:
    """Comparisons in words, by method: "m1 in TPR on A3, in TNR and L2 on A0 and A1; m2 in ..."."""
    by_method = grouped(made, lambda one: one.method)
    return "; ".join(f"{method} {', '.join(_places(mine))}" for method, mine in by_method.items())


def _places(made: Sequence[Comparison]) -> Iterator[str]:
    """Places with the same measures stand together."""
    on = grouped(made, lambda one: one.place)
    alike = grouped(on, lambda place: tuple(one.measure for one in on[place]))
    return (f"in {_listed(measures)} on {_listed(those)}" for measures, those in alike.items())


def _table(short: Sequence[Comparison]) -> list[str]:
    rows = []
    for (method, place), mine in grouped(short, lambda one: (one.method, one.place)).items():
        cells = {one.measure: f"**{one.text}**" if one.outcome == "behind" else one.text for one in mine}
        rows.append([method, place, *(cells.get(measure, "") for measure in MEASURES)])
    return table(["method", "on", *MEASURES], rows, left=2)


def _everywhere(made: Sequence[Comparison]) -> str:
    """All that was compared: "of m1 and m2 in TPR, ... and L2 on A0 and A1; of m4 in ..."."""
    by_method = grouped(made, lambda one: one.method)
    alike = grouped(by_method, lambda method: _where(by_method[method]))
    return "; ".join(
        f"of {_listed(those)} in {_listed(MEASURES)} on {where}" for where, those in alike.items()
    )


def _where(made: Sequence[Comparison]) -> str:
    """Where there are records."""
    seen = list(dict.fromkeys(one.place for one in made))
    whole = set(seen) >= set(TYPES)
    places = ["every perturbation", *(place for place in seen if place not in TYPES)] if whole else seen
    return _listed([f"{place} (without L2)" if place == SEGMENTS else place for place in places])


def _listed(words: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))
