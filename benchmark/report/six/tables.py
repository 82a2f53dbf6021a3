"""Tables of the six methods: kinds, errors, and both by group, with the paper's figures where it has any."""

from collections.abc import Callable, Iterator, Sequence

from ...cases import Level
from ...methods import PAPER, PUBLISHED
from ...real import REAL
from ...records import SAMPLED, Record
from ...scores import averages, confusion, grouped
from .. import beside_paper, paper
from ..cells import five, level_name, macro_rates, median, name_of, rate_text
from ..data import OURS, Data, median_seconds
from ..markdown import NOTHING, milliseconds, scientific, table

BESIDE = "shrec"
"""The set whose clouds are like those of which the paper has figures."""

Cell = Callable[[Sequence[Record]], str]


def shown(data: Data, set_: str) -> dict[str, list[Record]]:
    """The records of a set by method: primfit, the methods of the paper, and published answers."""
    found = data.by_method(data.of_set(set_))
    return {name: found[name] for name in (OURS, *PAPER, *PUBLISHED) if name in found}


def errors_of(set_: str) -> dict[str, str]:
    """The measures of a set, as records and as readers call them."""
    if set_ in SAMPLED:
        return {error: beside_paper.TABLE_2[error] for error in beside_paper.PUBLISHED}
    known = {} if set_ == REAL else {lengths_of(set_): "parameter error"}
    return known | {"mfe": "MFE", "hausdorff": "directed Hausdorff"}


def lengths_of(set_: str) -> str:
    """The distance between parameters, relative where clouds come in several units."""
    return "l2" if set_ in SAMPLED else "relative_l2"


def kinds(data: Data, set_: str) -> list[str]:
    """Macro averages and times; under each method of the paper what the paper says of it."""
    rows = []
    for method, records in shown(data, set_).items():
        seconds = milliseconds(median_seconds(records))
        rows.append([name_of(method), f"{len(records):,}", *macro_rates(records), seconds])
        if set_ == BESIDE and method in PAPER:
            published = (rate[method.upper()][5] for rate in paper.CLASSIFICATION.values())
            rows.append([f"{method.upper()} (paper)", "925", *map(rate_text, published), NOTHING])
    return table(["method", "clouds", *(f"macro {rate}" for rate in paper.CLASSIFICATION), "ms"], rows)


def errors(data: Data, set_: str) -> Iterator[str]:
    """Quartiles, mean and standard deviation of each measure, beside those of the truth and of the paper."""
    rows = []
    for error, title in errors_of(set_).items():
        rows += [[title, *cells] for cells in _of_error(data, set_, error)]
    yield from table(["measure", "method", "Q1", "Q2", "Q3", "mean", "std"], rows, left=2)


def _of_error(data: Data, set_: str, error: str) -> Iterator[list[str]]:
    own = {record.case: record.truth_errors.get(error) for record in data.of_set(set_)}
    known = [value for value in own.values() if value is not None]
    if known:
        yield ["*truth*", *five(known)]
    for method, records in shown(data, set_).items():
        yield [name_of(method), *five([record.error(error) for record in records])]
        if set_ == BESIDE and method in PAPER:
            published = paper.ERRORS[beside_paper.PUBLISHED[error]][method.upper()]
            yield [f"{method.upper()} (paper)", *map(scientific, published)]


def by_group(data: Data, set_: str, group: str) -> list[str]:
    """A row for each measure and method, a column for each level."""
    levels = data.levels(set_, group)
    rows = []
    for title, cell in _cells(set_).items():
        for method, records in shown(data, set_).items():
            at = grouped(records, lambda record: record.groups.get(group))
            cells = [_cell(cell, at, level) for level in levels]
            if any(text != NOTHING for text in cells):
                rows.append([title, name_of(method), *cells])
    return table(["measure", "method", *map(level_name, levels)], rows, left=2)


def _cell(cell: Cell, at: dict[Level | None, list[Record]], level: Level) -> str:
    return cell(at[level]) if level in at else NOTHING


def _cells(set_: str) -> dict[str, Cell]:
    """What is shown of each level, in one number."""
    medians = {f"{title}, median": _median_of(error) for error, title in errors_of(set_).items()}
    return {"clouds": _count, "macro TPR": _recall, **medians, "ms": _milliseconds}


def _count(records: Sequence[Record]) -> str:
    return f"{len(records):,}"


def _recall(records: Sequence[Record]) -> str:
    return rate_text(averages(confusion(records))["TPR"])


def _median_of(error: str) -> Cell:
    return lambda records: scientific(median(records, error))


def _milliseconds(records: Sequence[Record]) -> str:
    return milliseconds(median_seconds(records))


def by_cloud(data: Data, set_: str) -> list[str]:
    """L2 of each method on each cloud of a set."""
    methods = list(shown(data, set_))
    rows = []
    for case, records in grouped(data.of_set(set_), lambda record: (record.seed, record.case)).items():
        by_method = {record.method: record for record in records}
        cells = [scientific(by_method[m].error("l2")) if m in by_method else NOTHING for m in methods]
        first = records[0]
        rows.append([case[1], first.kind, level_name(first.groups.get("perturbation", NOTHING)), *cells])
    return table(["cloud", "truth", "perturbation", *map(name_of, methods)], rows, left=3)
