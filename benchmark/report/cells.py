"""What the cells of several tables hold."""

from collections.abc import Sequence

import numpy as np

from primfit.synthetic.recipes import KINDS

from ..cases import Level
from ..records import Record
from ..scores import REJECTIONS, answered, averages, confusion, share, spread
from .data import OURS
from .markdown import NOTHING, count, percent, scientific


def name_of(method: str) -> str:
    return f"**{method}**" if method == OURS else method


def level_name(level: Level) -> str:
    return f"{level:,}" if isinstance(level, int) else str(level)


def median(records: Sequence[Record], error: str) -> float:
    return spread([record.error(error) for record in records]).q2


def five(values: Sequence[float]) -> list[str]:
    """Quartiles, mean and standard deviation."""
    found = spread(values)
    return [scientific(value) for value in (found.q1, found.q2, found.q3, found.mean, found.std)]


def measured(records: Sequence[Record], error: str) -> list[Record]:
    """The records of the kinds for which a measure is defined."""
    return [
        r for r in records if r.kind in KINDS and ("position" not in error or r.kind in ("plane", "cylinder"))
    ]


def outcomes_of(records: Sequence[Record], failed: bool = False) -> list[str]:
    """Right, another kind, ambiguous, no_fit, and on request failed, of the wrong ones."""
    wrong = [answered(record) for record in records if not record.right]
    names = REJECTIONS if failed else REJECTIONS[:2]
    rejected = [wrong.count(name) for name in names]
    other = len([answer for answer in wrong if answer not in REJECTIONS])
    return [percent(share(records, lambda record: record.right)), count(other), *map(count, rejected)]


def macro_rates(records: Sequence[Record]) -> list[str]:
    """PPV, NPV, TPR, TNR, accuracy."""
    return [rate_text(value) for value in averages(confusion(records)).values()]


def rate_text(value: float) -> str:
    return NOTHING if np.isnan(value) else f"{value:.4f}"
