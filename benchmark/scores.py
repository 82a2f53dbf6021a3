"""Many records in few numbers: confusion matrices, rates per class, quartiles."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from primfit.fitting.geometry.vectors import Array
from primfit.synthetic.recipes import KINDS

from .records import Record

G = TypeVar("G")
T = TypeVar("T")

REJECTIONS = ("ambiguous", "no_fit", "failed")
"""Columns of a confusion matrix beside the kinds: answers that name no kind, and no answer at all."""
ANSWERS = (*KINDS, *REJECTIONS)


EXACT = 1e-9
"""A fit is exact where the root mean square distance of the surfaces is at most this share of the extent."""

CLOSE = 0.01
"""A fit is close where the root mean square distance of the surfaces is at most this share of the extent."""


def answered(record: Record) -> str:
    """The column of a record in the confusion matrix."""
    if record.failed:
        return "failed"
    if record.status == "fitted" and record.answer:
        return str(record.answer["kind"])
    return "ambiguous" if record.status == "ambiguous" else "no_fit"


def among(record: Record) -> bool:
    """Whether the kind is right, or the answer is `ambiguous` and names it."""
    return record.right or (record.status == "ambiguous" and record.kind in named(record))


def is_first(record: Record) -> bool:
    """Whether the true kind is answered, alone or as the first of several."""
    return named(record)[:1] == (record.kind,)


def named(record: Record) -> tuple[str, ...]:
    """The kinds that an answer names, the likeliest first; none of `no_fit` and of no answer."""
    if record.answer is None or record.status not in ("fitted", "ambiguous"):
        return ()
    return (str(record.answer["kind"]), *record.alternatives)


def confusion(records: Iterable[Record]) -> np.ndarray:
    """Counts (5, 8): rows are true kinds, columns `ANSWERS`; clouds of no kind have no row."""
    counts = np.zeros((len(KINDS), len(ANSWERS)), dtype=int)
    for record in records:
        if record.kind in KINDS:
            counts[KINDS.index(record.kind), ANSWERS.index(answered(record))] += 1
    return counts


def rates(counts: np.ndarray) -> dict[str, Array]:
    """Per class, shape (5,): PPV, NPV, TPR, TNR and accuracy of "this class or not"; NaN where undefined.

    A rejection predicts no class: it takes from TPR and accuracy, not from PPV. Source: Romanengo et al.
    2022, 2.2.1.
    """
    total = counts.sum()
    hit = np.diag(counts[:, : len(KINDS)]).astype(float)
    actual, predicted = counts.sum(axis=1), counts[:, : len(KINDS)].sum(axis=0)
    rest = total - actual - predicted + hit
    with np.errstate(invalid="ignore", divide="ignore"):
        return {
            "PPV": hit / predicted,
            "NPV": rest / (total - predicted),
            "TPR": hit / actual,
            "TNR": rest / (total - actual),
            "ACC": (hit + rest) / total,
        }


def macro(per_class: Array) -> float:
    """The mean over the classes for which a rate is defined; NaN where there is none."""
    defined = per_class[np.isfinite(per_class)]
    return float(defined.mean()) if len(defined) else np.nan


def averages(counts: np.ndarray) -> dict[str, float]:
    """Macro averages of the rates.

    PPV is that of the kinds that are among the clouds: one wrong answer of a kind that is not there would
    otherwise weigh as much as all answers of a kind that is.
    """
    found = rates(counts)
    found["PPV"] = np.where(counts.sum(axis=1) > 0, found["PPV"], np.nan)
    return {name: macro(values) for name, values in found.items()}


@dataclass(frozen=True)
class Spread:
    """How values are spread.

    Quartiles are those of all values, so that a wrong answer, which is infinitely far, counts; they are
    values that occur (the one at or below the rank). Mean and standard deviation are those of the finite
    ones.
    """

    q1: float
    q2: float
    q3: float
    mean: float
    std: float


def spread(values: Sequence[float]) -> Spread:
    """NaN throughout for no values."""
    ordered = np.array(values, float)
    finite = ordered[np.isfinite(ordered)]
    quartiles = np.quantile(ordered, [0.25, 0.5, 0.75], method="lower") if len(ordered) else [np.nan] * 3
    moments = (finite.mean(), finite.std()) if len(finite) else (np.nan, np.nan)
    q1, q2, q3, mean, std = map(float, (*quartiles, *moments))
    return Spread(q1, q2, q3, mean, std)


def share(records: Sequence[Record], holds: Callable[[Record], bool]) -> float:
    """The share for which something holds; NaN for no records."""
    return sum(map(holds, records)) / len(records) if records else np.nan


def is_close(record: Record) -> bool:
    """Whether the kind is right and the surface close; where no surface is right or known, that is all."""
    known = record.kind in KINDS and "surface" in record.errors
    return record.right and (not known or record.error("surface") <= CLOSE)


def is_exact(record: Record) -> bool:
    """Whether the kind is right and the surface found to within rounding."""
    return record.error("surface") <= EXACT


def grouped(things: Iterable[T], key: Callable[[T], G]) -> dict[G, list[T]]:
    """Things by key, keys in the order of their first thing."""
    groups: dict[G, list[T]] = {}
    for thing in things:
        groups.setdefault(key(thing), []).append(thing)
    return groups


def seconds(records: Iterable[Record]) -> list[float]:
    """Of the answers that came, and of those that were waited for in vain."""
    return [record.seconds for record in records if record.seconds is not None]


def over_least_squares(records: Iterable[Record]) -> tuple[float, int]:
    """Covariance-normalised errors of right answers over those of the reference fits, as root mean squares.

    Returns
    -------
    The ratio, NaN where no reference is known, and the number of clouds that it is made of. A surface error
    over what theory expects of it is covariance-normalized: see `benchmark.measures.reference_errors`.
    """
    squares = [
        (record.error("surface") / expected, reference / expected)
        for record in records
        if record.right
        and (reference := record.reference_errors.get("surface")) is not None
        and (expected := record.reference_errors.get("expected"))
    ]
    found, of_reference = np.mean(np.square(squares), axis=0) if squares else (np.nan, np.nan)
    return float(np.sqrt(found / of_reference)), len(squares)


def standard_errors(values: Sequence[float]) -> float:
    """How many standard errors the mean of two or more values is from 0; NaN where all are 0."""
    with np.errstate(all="ignore"):
        return float(np.mean(values) / (np.std(values, ddof=1) / np.sqrt(len(values))))
