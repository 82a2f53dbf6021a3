"""benchmark-details.md and benchmark-six-details.md: everything by class, perturbation, size and level."""

from collections.abc import Iterator, Sequence

from primfit.synthetic.recipes import KINDS

from ..real import REAL
from ..records import SAMPLED, Record
from ..scores import ANSWERS, REJECTIONS, averages, confusion, is_close, rates, share, spread
from . import paper
from .cells import five, level_name, macro_rates, measured, name_of, outcomes_of, rate_text
from .data import Data, described
from .markdown import NOTHING, commands, count, milliseconds, percent, scientific, table

WITHOUT_ERRORS = ("foreign", "sections", REAL)
"""Sets of whose clouds most have no true surface, or none that is known."""


def details(data: Data, beside: str) -> Iterator[str]:
    """All tables of what stands on the page `beside`."""
    yield "# Benchmark: all tables"
    yield ""
    yield "<!-- Written by `primfit bench report`. -->"
    yield ""
    yield (
        f"[{beside}]({beside}) has the pictures, and [benchmark.md](benchmark.md#the-measures) explains the "
        "measures. In the quartiles a wrong "
        "answer is infinitely far; mean and standard deviation are those of the right ones."
    )
    for set_ in data.sets:
        yield ""
        yield f"## {described(set_).title} (`{set_}`)"
        yield ""
        yield from commands(data.commands([set_]))
        if set_ != "foreign":
            yield ""
            yield from per_class(data, set_)
            yield ""
            yield from confusions(data, set_)
        for group in data.groups(set_):
            yield ""
            yield from by_group(data, set_, group)


def per_class(data: Data, set_: str) -> Iterator[str]:
    """Table 1 of the paper in full, with ours."""
    yield "Rates by class:"
    yield ""
    rows = []
    counts = {method: confusion(data.of_set(set_, method)) for method in data.deciders()}
    ours = {method: (rates(own), averages(own)) for method, own in counts.items()}
    for rate, published in paper.CLASSIFICATION.items():
        for method, (found, average) in ours.items():
            ordered = [float(found[rate][KINDS.index(kind)]) for kind in paper.KINDS]
            rows.append([rate, name_of(method), *map(rate_text, (*ordered, average[rate]))])
        if set_ in SAMPLED:
            rows += [
                [rate, f"{method} (paper)", *map(rate_text, numbers)] for method, numbers in published.items()
            ]
    yield from table(["rate", "method", *paper.KINDS, "macro"], rows, left=2)


def confusions(data: Data, set_: str) -> Iterator[str]:
    yield "Confusion matrices, a row for each true kind:"
    yield ""
    rows = []
    for method in data.deciders():
        for kind, counts in zip(KINDS, confusion(data.of_set(set_, method)), strict=True):
            rows.append([name_of(method), kind, *(count(int(number)) for number in counts)])
    yield from table(["method", "truth", *ANSWERS], rows, left=2)


FIVE = ("Q1", "Q2", "Q3", "mean", "std")
ERRORS = {
    "l2": "L2",
    "surface": "surface",
    "relative_position": "position",
    "mfe": "MFE",
    "hausdorff": "Hausdorff",
}
OF_THE_TRUTH = ("mfe", "hausdorff")
"""The measures of the tables of errors, and those which the truth has, too."""


def by_group(data: Data, set_: str, group: str) -> Iterator[str]:
    """Two tables with a row for each level and method: outcomes with rates and times, and errors."""
    rows = [
        (level, method, records)
        for level in data.levels(set_, group)
        for method, records in data.by_method(data.at_level(set_, group, level)).items()
    ]
    names = [[level_name(level), name_of(method)] for level, method, _ in rows]
    yield f"Outcomes by {group}:"
    yield ""
    header = [group, "method", "clouds", "kind right", "another kind", *REJECTIONS, "within 1%"]
    header += [f"macro {rate}" for rate in paper.CLASSIFICATION] + [f"ms {name}" for name in FIVE]
    cells = [_outcomes(records, data.decides(method)) for _, method, records in rows]
    yield from table(header, [name + cell for name, cell in zip(names, cells, strict=True)], left=2)
    if set_ in WITHOUT_ERRORS:
        return
    yield ""
    yield f"Errors by {group}; the truth's own beside:"
    yield ""
    header = [group, "method"]
    for error, title in ERRORS.items():
        header += [f"{title} {name}" for name in FIVE] + (
            ["truth Q2"] if error in ("mfe", "hausdorff") else []
        )
    yield from table(header, [name + _errors(row[2]) for name, row in zip(names, rows, strict=True)], left=2)


def _outcomes(records: Sequence[Record], decides: bool) -> list[str]:
    right, *wrong = outcomes_of(records, failed=True)
    times = spread([record.seconds for record in records if record.seconds is not None])
    return [
        f"{len(records):,}",
        right if decides else "given",
        *wrong,
        percent(share(records, is_close)),
        *(macro_rates(records) if decides else [NOTHING] * len(paper.CLASSIFICATION)),
        *map(milliseconds, (times.q1, times.q2, times.q3, times.mean, times.std)),
    ]


def _errors(records: Sequence[Record]) -> list[str]:
    cells = []
    for error in ERRORS:
        cells += five([record.error(error) for record in measured(records, error)])
        if error in OF_THE_TRUTH:
            own = [value for record in records if (value := record.truth_errors.get(error)) is not None]
            cells.append(scientific(spread(own).q2))
    return cells
