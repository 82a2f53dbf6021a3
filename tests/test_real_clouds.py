"""The 24 real clouds of SHREC 2022, where a development copy of the data lies beside the checkout."""

import json

import numpy as np
import pytest

from primfit import export, fit
from primfit.app.exports import FORMATS
from primfit.benchmark.measures import is_right, l2
from primfit.benchmark.track import shrec22_cases
from tests.paths import SHARED

DATA = SHARED / "data" / "shrec22"

pytestmark = pytest.mark.skipif(
    not DATA.is_dir(), reason=f"no SHREC 2022 clouds in {DATA.name} beside the checkout"
)


@pytest.mark.parametrize("classifier", ["knn", "none"])
def test_real_clouds_are_recognized_exactly(classifier: str) -> None:
    errors = []
    for case in shrec22_cases(DATA):
        answer = fit(case.points, classifier=classifier)
        right = is_right(answer.status, answer.primitive, case.kind)
        errors.append(l2(answer.primitive, case.truth) if right else np.inf)
    assert np.isfinite(errors).all()
    assert np.quantile(errors, 0.75) <= 1e-10


def test_every_artifact_of_every_real_cloud_is_made() -> None:
    for case in shrec22_cases(DATA):
        files = export(fit(case.points), list(FORMATS), case.points, unit="mm")
        assert files.keys() == FORMATS.keys()
        form = json.loads(files["form"])
        rounding = 1e-12
        assert form["minimum_zone"]["form_error"] <= form["least_squares"]["form_error"] + rounding
        assert len(files["report"]) < 1_000_000
        # Residuals that are all rounding are not drawn: the map and the histogram are missing then.
        exact = b"All inliers lie on the surface" in files["report"]
        assert files["report"].count(b"<svg") == (3 if exact else 5)
