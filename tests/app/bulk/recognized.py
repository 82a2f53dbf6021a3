"""Answered segments of every kind and status, and their rows, which the tests of this folder share."""

from functools import cache
from typing import Any

import numpy as np

from primfit.app.bulk.refs import Ref
from primfit.app.bulk.rows import Row, answered_row, problem_row
from primfit.app.engine.answer import answered
from primfit.app.readers.cloud import Cloud
from primfit.fitting.answer.result import Recognition
from tests.fitting.clouds import EXAMPLES, noisy

_ANGLES = np.linspace(0.0, 6.0, 60)
_RING = np.stack([np.cos(_ANGLES), np.sin(_ANGLES), np.zeros(60)], axis=1)
_ASKED: dict[str, tuple[Any, dict[str, Any]]] = {
    **{kind: (noisy(EXAMPLES[kind], 300, 0.005), {}) for kind in EXAMPLES},
    "ambiguous": (np.vstack([_RING, _RING * [2, 2, 1] + np.array([0, 0, 1])]), {"kinds": ["sphere", "cone"]}),
    "no_fit": (np.random.default_rng(0).uniform(size=(400, 3)), {}),
    "no primitive": (noisy(EXAMPLES["plane"], 300, 0.0), {"kinds": ["torus"]}),
    "outlier": (np.vstack([noisy(EXAMPLES["sphere"], 300, 0.005), [[6.0, 6.0, 6.0]]]), {}),
}
NAMES = (*_ASKED, "problem")
PROBLEM = "points: 2 points; at least 3 are needed"


def ref(number: int) -> Ref:
    return Ref(f"scans/hall.las#{number}", "scans/hall.las", number, 300, "/store", 300 * number, 300)


@cache
def found(name: str) -> tuple[Recognition, dict[str, Any]]:
    """What was recognized, and the answer."""
    points, options = _ASKED[name]
    return answered(Cloud(points, ("x", "y", "z"), None, "csv", unit="m"), options)


@cache
def rows() -> tuple[Row, ...]:
    """A row of each, in the order of `NAMES`."""
    answers = (answered_row(ref(number), *found(name)) for number, name in enumerate(_ASKED))
    return (*answers, problem_row(ref(len(_ASKED)), PROBLEM))
