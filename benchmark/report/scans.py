"""The sections that stand first: segments of real scans, and clouds as sensors make them."""

from collections.abc import Iterator, Sequence

from primfit.synthetic.recipes import KINDS

from ..real import REAL
from ..records import Record
from ..scores import REJECTIONS, among, answered, grouped, named, share
from .cells import name_of
from .data import Data, described, median_seconds
from .markdown import NOTHING, commands, count, milliseconds, percent, table

SENSOR = "sensor"
FIRST = (REAL, SENSOR)
"""The sets that are shown before all tables of bars and synthetic clouds."""


def first(data: Data, set_: str) -> Iterator[str]:
    """Who is right how often, on each kind and each group; of real segments also each answer by file."""
    description = described(set_)
    yield f"## {description.title}"
    yield ""
    yield description.about
    yield ""
    yield from recognised(data, set_)
    yield ""
    for group in data.groups(set_):
        yield from by_group(data, set_, group)
        yield ""
    if set_ == REAL:
        yield from by_file(data)
        yield ""
    yield from commands([*data.commands([set_]), "primfit bench report"])


def _deciders(data: Data, set_: str) -> dict[str, list[Record]]:
    found = data.by_method(data.of_set(set_))
    return {method: records for method, records in found.items() if data.decides(method)}


def recognised(data: Data, set_: str) -> list[str]:
    """A row for each method that finds the kind."""
    header = ["method", "clouds", "right", "or among several", "another kind", *REJECTIONS]
    rows = []
    for method, records in _deciders(data, set_).items():
        wrong = [answered(record) for record in records if not record.right]
        rejected = [wrong.count(name) for name in REJECTIONS]
        rows.append(
            [
                name_of(method),
                f"{len(records):,}",
                percent(share(records, lambda record: record.right)),
                percent(share(records, among)),
                count(len(wrong) - sum(rejected)),
                *map(count, rejected),
                *(_right_of(records, kind) for kind in KINDS),
                milliseconds(median_seconds(records)),
            ]
        )
    return table([*header, *KINDS, "ms"], rows)


def _right_of(records: Sequence[Record], kind: str) -> str:
    """How many clouds of this kind are right, of how many."""
    mine = [record for record in records if record.kind == kind]
    return f"{sum(record.right for record in mine)} of {len(mine)}" if mine else NOTHING


def by_group(data: Data, set_: str, group: str) -> Iterator[str]:
    levels = data.levels(set_, group)
    yield f"Right, and right or `ambiguous` with the true kind among those named, by {group}:"
    yield ""
    rows = []
    for method, records in _deciders(data, set_).items():
        at = grouped(records, lambda record: record.groups.get(group))
        rows.append([name_of(method), *(_both(at.get(level, [])) for level in levels)])
    yield from table(["method", *map(str, levels)], rows)


def _both(records: Sequence[Record]) -> str:
    right, either = share(records, lambda record: record.right), share(records, among)
    return f"{percent(right, 0)} / {percent(either, 0)}"


def by_file(data: Data) -> Iterator[str]:
    """A row for each segment: the truth and the answers."""
    yield "Each segment, what is not right in bold:"
    yield ""
    methods = _deciders(data, REAL)
    rows = []
    for (_, name), records in grouped(data.of_set(REAL), lambda record: (record.seed, record.case)).items():
        by_method = {record.method: record for record in records}
        answers = [_answer(by_method[method]) if method in by_method else NOTHING for method in methods]
        rows.append([f"`{name}`", records[0].kind, *answers, f"{records[0].points:,}"])
    header = ["segment", "truth", *map(name_of, methods), "points"]
    yield from table(header, rows, left=len(header) - 1)


def _answer(record: Record) -> str:
    """The kind, or the status with the kinds that it names."""
    word = answered(record)
    if word == "ambiguous":
        word = f"ambiguous: {', '.join(named(record))}"
    return word if record.right else f"**{word}**"
