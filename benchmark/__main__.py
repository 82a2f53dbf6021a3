"""Recognise labelled clouds and print who was right, how exact, and how fast.

python -m benchmark --synthetic 500 --seed 1
python -m benchmark --synthetic 200 --seed 1 --classifier reverse
python -m benchmark --shrec22 DIR
"""

import argparse
import itertools
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from benchmark.cases import Case, shrec22_cases, synthetic_cases
from benchmark.measures import is_right, l2
from fitting.classifier import Classifier
from fitting.geometry import Array
from fitting.primitives import KINDS
from fitting.recognize import recognize
from fitting.result import Recognition
from models import CLASSIFIERS, load_classifier


class Reverse:
    """The worst ranking there is: the true kind last, the others from the most general on."""

    def __init__(self, truth: str) -> None:
        self.order = [*(kind for kind in reversed(KINDS) if kind != truth), truth]

    def rank(self, points: Array, normals: Array) -> Mapping[str, float]:
        return {kind: 2.0 ** (4 - place) / 31.0 for place, kind in enumerate(self.order)}


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmark", description=__doc__.splitlines()[0])
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--synthetic", type=int, metavar="N", help="N fresh benchmark-like clouds")
    source.add_argument("--shrec22", type=Path, metavar="DIR", help="a folder in the track's layout")
    parser.add_argument("--seed", type=int, default=1, help="of the synthetic clouds (default 1)")
    parser.add_argument("--classifier", choices=[*CLASSIFIERS, "reverse"], default=CLASSIFIERS[0])
    options = parser.parse_args()
    cases = (
        shrec22_cases(options.shrec22)
        if options.shrec22
        else synthetic_cases(options.seed, options.synthetic)
    )
    report([(case, *_timed(case, options.classifier)) for case in cases])


def report(records: list[tuple[Case, Recognition, float]]) -> None:
    """Print a line for each cloud that is not right, a table of groups, and the summary."""
    errors = np.array([_error(case, answer) for case, answer, _ in records])
    first = np.array([answer.attempts[0].kind == case.truth.kind for case, answer, _ in records])
    for (case, answer, _), error in zip(records, errors, strict=True):
        if np.isinf(error):
            print(f"wrong: {case.name} {case.truth.kind} {case.group} -> {answer.status}: {answer.message}")
    labels = (
        np.array([case.truth.kind for case, _, _ in records]),
        np.array([case.group for case, _, _ in records]),
    )
    for group in itertools.chain(KINDS, sorted(set(labels[1]) - {""})):
        chosen = (labels[0] == group) | (labels[1] == group)
        if chosen.any():
            print(f"{group:>9}: right {np.isfinite(errors[chosen]).mean():7.2%} of {int(chosen.sum())}")
    quartiles = ", ".join(f"{q:.1e}" for q in np.quantile(errors, [0.25, 0.5, 0.75], method="nearest"))
    tries = np.mean([len(answer.attempts) for _, answer, _ in records])
    times = 1e3 * np.array([seconds for _, _, seconds in records])
    print(f"right {np.isfinite(errors).sum()} of {len(errors)} ({np.isfinite(errors).mean():.2%})")
    print(f"first in the ranking right {first.mean():.2%}; refinements a cloud {tries:.2f}")
    shares = [f"below {bound:g} {np.mean(errors < bound):.2%}" for bound in (1e-6, 1e-12)]
    print(f"L2 quartiles {quartiles}; {', '.join(shares)}")
    print(f"time a cloud: median {np.median(times):.1f} ms, mean {times.mean():.1f} ms")


def _timed(case: Case, name: str) -> tuple[Recognition, float]:
    classifier: Classifier | None = Reverse(case.truth.kind) if name == "reverse" else load_classifier(name)
    start = time.perf_counter()
    answer = recognize(case.points, classifier=classifier)
    return answer, time.perf_counter() - start


def _error(case: Case, answer: Recognition) -> float:
    """L2, infinite where the answer is wrong."""
    if not is_right(answer, case.truth) or answer.primitive is None:
        return np.inf
    return l2(answer.primitive, case.truth)


if __name__ == "__main__":
    main()
