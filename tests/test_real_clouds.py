"""The 24 real clouds of SHREC 2022, where a development copy of the data lies beside the checkout."""

from pathlib import Path

import numpy as np
import pytest

from benchmark.measures import is_right, l2
from benchmark.track import shrec22_cases
from primfit import fit

DATA = Path(__file__).parents[2] / "shared" / "data" / "shrec22"

pytestmark = pytest.mark.skipif(
    not DATA.is_dir(), reason=f"no SHREC 2022 clouds in {DATA.name} beside the checkout"
)


@pytest.mark.parametrize("classifier", ["knn", "none"])
def test_real_clouds_are_recognised_exactly(classifier: str) -> None:
    errors = []
    for case in shrec22_cases(DATA):
        answer = fit(case.points, classifier=classifier)
        right = is_right(answer.status, answer.primitive, case.kind)
        errors.append(l2(answer.primitive, case.truth) if right else np.inf)
    assert np.isfinite(errors).all()
    assert np.quantile(errors, 0.75) <= 1e-10
