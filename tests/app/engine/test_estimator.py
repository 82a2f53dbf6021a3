"""`PrimitiveFitter` keeps the rules of scikit-learn, and gives the answer of `primfit.fit`."""

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.model_selection import GridSearchCV, cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import FunctionTransformer
from sklearn.utils.estimator_checks import parametrize_with_checks
from sklearn.utils.validation import validate_data

import primfit
from primfit.app.engine.estimator import PrimitiveFitter
from primfit.fitting.geometry.vectors import Array
from tests.fitting.clouds import EXAMPLES, noisy, sample

CYLINDER = noisy(EXAMPLES["cylinder"], 400, 0.01)

COLUMNS = {
    2: [
        "check_classifier_data_not_an_array",
        "check_estimators_fit_returns_self",
        "check_estimators_overwrite_params",
        "check_fit_check_is_fitted",
        "check_fit_idempotent",
        "check_n_features_in",
        "check_outliers_fit_predict",
        "check_outliers_train",
        "check_readonly_memmap_input",
        "check_sample_weights_not_an_array",
        "check_sample_weights_not_overwritten",
        "check_sample_weights_pandas_series",
        "check_sample_weights_shape",
    ],
    4: ["check_n_features_in_after_fitting"],
    5: ["check_estimators_dtypes"],
    10: ["check_array_api_input", "check_dtype_object", "check_positive_only_tag_during_fit"],
    20: ["check_all_zero_sample_weights_error"],
    30: ["check_sample_weight_equivalence_on_dense_data"],
}
"""Checks of scikit-learn whose data are no points in space, by the number of their columns."""


class OfAnyColumns(PrimitiveFitter):
    """The estimator on what those checks make up: the first three columns, or a rough plane of fewer, with a
    tenth of the points off it."""

    def _points(self, X: Any, *, reset: bool) -> Array:
        given = validate_data(self, X, reset=reset, dtype=np.float64, ensure_min_samples=3 if reset else 1)
        if given.shape[1] < 3:
            x, y = given[:, 0], given[:, -1]
            off = np.sin(1000.0 * x) > 0.95
            third = np.where(off, 3.0 * np.sin(500.0 * y), 0.02 * np.sin(997.0 * y))
            given = np.column_stack([given, third])
        return np.asarray(given[:, :3])


def expected_to_fail(estimator: Any) -> dict[str, str]:
    """The checks that cannot hold, with the reason."""
    if isinstance(estimator, OfAnyColumns):
        return {
            "check_fit2d_1feature": "not on one coordinate: the check runs on the estimator itself",
        }
    return {
        name: f"its samples have {n} features; a point in space has 3"
        for n, names in COLUMNS.items()
        for name in names
    }


@parametrize_with_checks([PrimitiveFitter(), OfAnyColumns()], expected_failed_checks=expected_to_fail)
def test_it_is_an_estimator(estimator: Any, check: Callable[[Any], None]) -> None:
    check(estimator)


def test_it_gives_the_answer_of_fit() -> None:
    options: dict[str, Any] = {"kinds": ["cylinder", "cone"], "criterion": "huber", "seed": 3}
    fitter = PrimitiveFitter(
        **options, constraints={"radius": {"max": 2.0}}, initial_guess=EXAMPLES["cylinder"]
    )
    weights = np.random.default_rng(2).uniform(1.0, 2.0, 400)
    fitter.fit(CYLINDER, sample_weight=weights)
    expected = primfit.fit(
        CYLINDER,
        weights=weights,
        constraints={"radius": {"max": 2.0}},
        initial_guess=EXAMPLES["cylinder"],
        **options,
    )
    assert fitter.recognition_.to_json() == expected.to_json()
    copy = pickle.loads(pickle.dumps(clone(fitter).fit(CYLINDER, sample_weight=weights)))
    np.testing.assert_array_equal(copy.score_samples(CYLINDER), fitter.score_samples(CYLINDER))
    assert fitter.score(CYLINDER) == pytest.approx(-expected.error.mean, rel=1e-9)  # type: ignore[union-attr]


def test_outliers_are_those_that_the_fit_rejects() -> None:
    rng = np.random.default_rng(7)
    far = rng.uniform(-3.0, 3.0, (60, 3))
    fitter = PrimitiveFitter(kinds=["cylinder"]).fit(np.vstack([CYLINDER, far]))
    found = fitter.recognition_
    assert found.error is not None and found.noise is not None
    assert fitter.inlier_mask_.mean() == pytest.approx(found.error.inlier_share, abs=1e-12)
    assert fitter.inlier_threshold_ == pytest.approx(4.0 * found.noise.scale)
    fresh = noisy(EXAMPLES["cylinder"], 1000, 0.01, seed=9)
    assert (fitter.predict(fresh) == 1).mean() > 0.99
    off = fresh + 0.1 * EXAMPLES["cylinder"].gradient(fresh)
    assert (fitter.predict(off) == -1).mean() > 0.99
    np.testing.assert_array_equal(fitter.fit_predict(fresh) == 1, fitter.inlier_mask_)


def test_other_points_of_an_exact_surface_are_inliers() -> None:
    fitter = PrimitiveFitter().fit(sample(EXAMPLES["torus"], 300))
    assert (fitter.predict(sample(EXAMPLES["torus"], 300, seed=4)) == 1).all()
    assert fitter.inlier_threshold_ < 1e-13


def test_it_stands_in_searches_and_pipelines() -> None:
    kinds = [["plane"], ["sphere"], ["cylinder"]]
    search = GridSearchCV(PrimitiveFitter(criterion="least_squares"), {"kinds": kinds}, cv=3).fit(CYLINDER)
    assert search.best_params_ == {"kinds": ["cylinder"]}
    np.testing.assert_allclose(cross_val_score(PrimitiveFitter(), CYLINDER, cv=3), -0.008, atol=2e-3)
    in_meters = make_pipeline(FunctionTransformer(lambda points: points / 1000.0), PrimitiveFitter())
    assert in_meters.fit(CYLINDER)[-1].primitive_.radius == pytest.approx(0.0008, rel=0.01)
    assert (in_meters.predict(CYLINDER) == 1).all()


def test_a_cloud_of_which_nothing_could_be_made_raises() -> None:
    flat = noisy(EXAMPLES["cylinder"], 50, 0.01) * [1.0, 1.0, 0.0]
    with pytest.raises(ValueError, match=r"no primitive was found: .* lie in one plane"):
        PrimitiveFitter(kinds=["sphere"]).fit(flat)


def test_constraints_are_taken_as_a_mapping_or_as_what_is_made_of_it() -> None:
    plain = {"radius": {"min": 0.5, "max": 2.0}}
    known = primfit.Constraints(radius=primfit.Range(0.5, 2.0))
    expected = primfit.fit(CYLINDER, constraints=plain)
    assert expected.active_constraints == {"radius": "bounds, not active"}
    assert primfit.fit(CYLINDER, constraints=known) == expected
    fitter = clone(primfit.PrimitiveFitter(constraints=known))
    assert fitter.fit(CYLINDER).recognition_ == expected
    assert fitter.inlier_mask_.shape == (400,)
