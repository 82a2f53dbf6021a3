"""Tables 1 and 2 of the paper, with ours in the same form."""

from collections.abc import Iterator, Sequence

import numpy as np

from ..measures import GRID
from ..records import Record
from ..track import TRACK
from . import paper
from .cells import five, macro_rates, name_of
from .data import Data
from .markdown import scientific, table


def beside_the_paper(data: Data, set_: str) -> Iterator[str]:
    """Tables 1 and 2 of the paper, with ours in the same form."""
    records = data.of_set(set_)
    yield "### Beside the paper"
    yield ""
    yield (
        "*M1 (paper)* to *M6 (paper)* are the numbers of the paper's tables 1 and 2, measured by its authors "
        "on their 925 test clouds; the others were measured here, on "
        + ("other clouds of the same laws." if set_ != TRACK else "the clouds of the folder.")
    )
    yield ""
    yield "Classification, macro averages (every class: [benchmark-details.md](benchmark-details.md)):"
    yield ""
    rows = [[name_of(method), *macro_rates(data.of_set(set_, method))] for method in data.deciders()]
    for method in next(iter(paper.CLASSIFICATION.values())):
        rows.append(
            [f"{method} (paper)", *(f"{rate[method][5]:.4f}" for rate in paper.CLASSIFICATION.values())]
        )
    yield from table(["method", *paper.CLASSIFICATION], rows)
    yield ""
    yield (
        "Errors in the unit of the clouds. The quartiles count a wrong answer as infinitely far; mean and "
        "standard deviation are those of the right ones. *truth* is what the true parameters reach on the "
        "same clouds. The paper measured MFE and Hausdorff distance to samples of the surface, which lie "
        f"some distance apart, on partly denoised points. Ours with {GRID} x {GRID} samples stand beside its "
        "numbers; compare them with the truth's."
    )
    for error, title in TABLE_2.items():
        yield ""
        yield from table([title, "Q1", "Q2", "Q3", "mean", "std"], _table_2(data, records, error))


TABLE_2 = {
    "l2": "L2",
    "mfe": "MFE, exact distances",
    "mfe_sampled": "MFE, sampled surface",
    "hausdorff": "directed Hausdorff, exact distances",
    "hausdorff_sampled": "directed Hausdorff, sampled surface",
}


PUBLISHED = {"l2": "l2", "mfe_sampled": "mfe", "hausdorff_sampled": "hausdorff"}
"""Our measure and that of the paper's table."""


def _table_2(data: Data, records: Sequence[Record], error: str) -> Iterator[list[str]]:
    if error != "l2":
        own = {record.key[:3]: record.truth_errors.get(error) for record in records}
        yield ["*truth*", *five([np.inf if value is None else value for value in own.values()])]
    for method, mine in data.by_method(records).items():
        given = "" if data.decides(method) else " (kind given)"
        yield [name_of(method) + given, *five([record.error(error) for record in mine])]
    if error in PUBLISHED:
        for method, numbers in paper.ERRORS[PUBLISHED[error]].items():
            yield [f"{method} (paper)", *map(scientific, numbers)]
