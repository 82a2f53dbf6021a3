"""benchmark-details.md: everything by class, perturbation, size and level."""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmark.records import SAMPLED, Record
from benchmark.report import paper
from benchmark.report.cells import five, level_name, macro_rates, measured, median, name_of, outcomes_of
from benchmark.report.data import Data, described
from benchmark.report.markdown import NOTHING, commands, count, milliseconds, percent, scientific, table
from benchmark.scores import (
    ANSWERS,
    REJECTIONS,
    confusion,
    is_close,
    macro,
    rates,
    share,
    spread,
)
from fitting.primitives import KINDS


def details(data: Data) -> Iterator[str]:
    """benchmark-details.md: everything by class, perturbation, size and level."""
    yield "# Benchmark: all tables"
    yield ""
    yield "<!-- Written by `primfit bench report`. -->"
    yield ""
    yield (
        "[benchmark.md](benchmark.md) explains the measures and has the pictures. In the quartiles a wrong "
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
            yield from detailed(data, set_, group)


def per_class(data: Data, set_: str) -> Iterator[str]:
    """Table 1 of the paper in full, with ours."""
    yield "Rates by class:"
    yield ""
    rows = []
    ours = {method: rates(confusion(data.of_set(set_, method))) for method in data.deciders()}
    for rate, published in paper.CLASSIFICATION.items():
        for method, found in ours.items():
            ordered = [float(found[rate][KINDS.index(kind)]) for kind in paper.KINDS]
            rows.append([rate, name_of(method), *map(_rate, (*ordered, macro(found[rate])))])
        if set_ in SAMPLED:
            rows += [
                [rate, f"{method} (paper)", *map(_rate, numbers)] for method, numbers in published.items()
            ]
    yield from table(["rate", "method", *paper.KINDS, "macro"], rows, left=2)


def _rate(value: float) -> str:
    return NOTHING if np.isnan(value) else f"{value:.4f}"


def confusions(data: Data, set_: str) -> Iterator[str]:
    yield "Confusion matrices, a row for each true kind:"
    yield ""
    rows = []
    for method in data.deciders():
        for kind, counts in zip(KINDS, confusion(data.of_set(set_, method)), strict=True):
            rows.append([name_of(method), kind, *(count(int(number)) for number in counts)])
    yield from table(["method", "truth", *ANSWERS], rows, left=2)


def detailed(data: Data, set_: str, group: str) -> Iterator[str]:
    """A row for each level and method with every measure."""
    yield f"By {group}:"
    yield ""
    header = [group, "method", "clouds", "kind right", "another kind", *REJECTIONS, "within 1 %"]
    header += [f"macro {rate}" for rate in paper.CLASSIFICATION]
    header += [f"L2 {name}" for name in ("Q1", "Q2", "Q3", "mean", "std")]
    header += ["surface Q1", "surface Q2", "surface Q3", "position Q2"]
    header += ["MFE Q2", "of the truth", "Hausdorff Q2", "of the truth", "ms Q1", "ms Q2", "ms Q3"]
    rows = []
    for level in data.levels(set_, group):
        at = [record for record in data.of_set(set_) if record.groups.get(group) == level]
        for method, records in data.by_method(at).items():
            rows.append([level_name(level), name_of(method), *_detailed(records, data.decides(method))])
    yield from table(header, rows, left=2)


def _detailed(records: Sequence[Record], decides: bool) -> list[str]:
    right, *wrong = outcomes_of(records, failed=True)
    surface = spread([record.error("surface") for record in measured(records, "surface")])
    times = spread([record.seconds for record in records if record.seconds is not None])
    cells = [f"{len(records):,}", right if decides else "given", *wrong, percent(share(records, is_close))]
    cells += macro_rates(records) if decides else [NOTHING] * len(paper.CLASSIFICATION)
    cells += five([record.error("l2") for record in measured(records, "l2")])
    cells += map(
        scientific,
        (surface.q1, surface.q2, surface.q3, median(measured(records, "position"), "relative_position")),
    )
    for error in ("mfe", "hausdorff"):
        own = [value for record in records if (value := record.truth_errors.get(error)) is not None]
        cells += map(scientific, (median(measured(records, error), error), spread(own).q2))
    return [*cells, *map(milliseconds, (times.q1, times.q2, times.q3))]
