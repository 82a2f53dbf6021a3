"""The table of `primfit bench proofs`: each bar beside the figures that were measured."""

from collections.abc import Iterator, Sequence

import numpy as np

from ..proofs import PROOFS
from ..proofs.records import ProofRecord
from .markdown import NOTHING, table
from .proof_bars import PROOF_BARS, ProofBar


def proven(records: Sequence[ProofRecord]) -> Iterator[str]:
    """The table of all bars; those whose set was not run say so."""
    yield "### From fresh seeds, beside independent optimizers"
    yield ""
    rows = [[bar.case, bar.bar, *_cells(bar, records)] for bar in PROOF_BARS]
    yield from table(["case", "bar", "measured: largest (99%)", "cases", "met?", "command"], rows, left=3)
    yield ""
    yield from _beyond(records)
    yield (
        "*99%*: so many cases are below. *beyond*: cases that miss; *without an answer* are those of them "
        "that have no figure: no fit where there is one, or another kind or status after a transformation. "
        "[benchmarking.md](benchmarking.md#proofs) says what the figures are."
    )


def _cells(bar: ProofBar, records: Sequence[ProofRecord]) -> list[str]:
    concerned = [record for record in records if bar.concerns(record)]
    if not concerned:
        return ["not run", "", NOTHING, NOTHING]
    figures = {name: values for name in bar.limits if (values := _values(concerned, name))}
    texts = [(f"{name} " if len(bar.limits) > 1 else "") + _spread(each) for name, each in figures.items()]
    beyond = sum(map(bar.misses, concerned))
    none = sum(
        bool(each.note) or None in (each.figures.get(name, 0.0) for name in bar.limits) for each in concerned
    )
    texts += [f"**{beyond} beyond**" + (f", {none} without an answer" if none else "")] if beyond else []
    met = "yes" if not beyond else "**no**"
    return ["; ".join(texts), f"{len(concerned):,}", met, f"`{_command(bar.set, records)}`"]


def _values(records: Sequence[ProofRecord], name: str) -> list[float]:
    found = (record.figures.get(name) for record in records)
    return [value for value in found if value is not None]


def _spread(values: Sequence[float]) -> str:
    return f"{_number(max(values))} ({_number(float(np.quantile(values, 0.99, method='inverted_cdf')))})"


def _number(value: float) -> str:
    return "0" if value == 0.0 else f"{value:.3g}"


def _command(set_: str, records: Sequence[ProofRecord]) -> str:
    mine = [record for record in records if record.set == set_]
    full = "--full" if len(mine) == PROOFS[set_].full else f"--n {len(mine)}"
    return f"primfit bench proofs --set {set_} {full} --seed {mine[0].seed}"


def _beyond(records: Sequence[ProofRecord]) -> Iterator[str]:
    """Which cases miss, so that each can be done again."""
    for set_ in PROOFS:
        missing = sorted(
            {
                r.case
                for r in records
                for bar in PROOF_BARS
                if bar.set == set_ and bar.concerns(r) and bar.misses(r)
            }
        )
        if missing:
            yield f"Cases of `{set_}` that miss: {', '.join(map(str, missing))}."
            yield ""
