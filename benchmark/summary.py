"""What the terminal shows after a run."""

from collections.abc import Sequence

import numpy as np
from rich.table import Table

from primfit.synthetic.recipes import KINDS

from .records import Record
from .scores import answered, grouped, seconds, share, spread

CAPTION = (
    "other: another kind; amb., none: ambiguous, no_fit. Errors and times are medians, a wrong answer is "
    "infinitely far; surface: distance of the surfaces over the extent; fits: kinds fitted a cloud; first: "
    "the first was right."
)


def summary(records: Sequence[Record]) -> Table:
    """A row for each method on each set."""
    table = Table(box=None, padding=(0, 0, 0, 1), pad_edge=False, caption=CAPTION, caption_justify="left")
    table.add_column("", no_wrap=True)
    for name in ("right", "other", "amb.", "none", "fail", "L2", "surface", "fits", "first", "ms"):
        table.add_column(name, justify="right", no_wrap=True)
    for set_, of_set in grouped(records, lambda record: record.set).items():
        table.add_row(f"[bold]{set_}")
        for method, mine in grouped(of_set, lambda record: record.method).items():
            table.add_row(f" {method}", *_cells(mine))
    return table


def _cells(records: Sequence[Record]) -> list[str]:
    wrong = [answered(record) for record in records if not record.right]
    rejections = [wrong.count(name) for name in ("ambiguous", "no_fit", "failed")]
    medians = [spread([record.error(name) for record in records]).q2 for name in ("l2", "surface")]
    times = seconds(records)
    told = [record for record in records if record.attempts]
    ranked = [record for record in told if record.kind in KINDS]
    return [
        f"{sum(record.right for record in records)}/{len(records)}",
        *(str(number or "") for number in (len(wrong) - sum(rejections), *rejections)),
        *(f"{value:.1e}" if np.isfinite(value) else "" for value in medians),
        f"{np.mean([len(record.attempts) for record in told]):.2f}" if told else "",
        f"{100 * share(ranked, lambda record: record.attempts[0] == record.kind):.0f}%" if ranked else "",
        f"{1e3 * spread(times).q2:.1f}" if times else "",
    ]


def wrong_line(record: Record) -> str:
    """One wrong answer."""
    groups = ", ".join(f"{name} {value}" for name, value in record.groups.items())
    case = f"{record.set} {record.case}"
    return f"wrong: {case}, {record.kind} ({groups}): {record.method}: {answered(record)}; {record.note}"
