"""Answers show themselves: their points, residuals and pictures, in a notebook and with matplotlib."""

import pickle
import sys
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest

import primfit
from tests.fitting.clouds import EXAMPLES, noisy

matplotlib.use("Agg")

POINTS = noisy(EXAMPLES["cylinder"], 300, 0.01)
POINTS[7] += 3.0
FOUND = primfit.fit(POINTS)
NOISE = np.random.default_rng(0).uniform(size=(500, 3))


def test_an_answer_knows_the_residuals_of_its_points_and_which_belong_to_it() -> None:
    assert FOUND.primitive is not None
    np.testing.assert_array_equal(FOUND.residuals, FOUND.primitive.signed_distance(POINTS))
    assert FOUND.inliers.dtype == bool and np.flatnonzero(~FOUND.inliers).tolist() == [7]
    given = primfit.residuals(FOUND, POINTS)
    assert given == primfit.residuals(FOUND)
    assert primfit.form_errors(FOUND, POINTS) == primfit.form_errors(FOUND)
    assert primfit.export(FOUND, "residuals_csv", POINTS) == FOUND.export("residuals_csv")


def test_a_pickled_answer_is_small_and_takes_its_points_again() -> None:
    message = pickle.dumps(FOUND)
    assert len(message) < POINTS.nbytes
    left = pickle.loads(message)
    for ask in (lambda: left.residuals, lambda: left.inliers, lambda: primfit.residuals(left)):
        with pytest.raises(primfit.InvalidPointCloudError, match="with_points"):
            ask()
    with pytest.raises(primfit.InvalidPointCloudError, match=r"\(2, 2\); \(N, 3\)"):
        left.with_points([[0, 0], [1, 1]])
    np.testing.assert_array_equal(left.with_points(POINTS).residuals, FOUND.residuals)
    assert "<svg" not in left._repr_html_() and "cylinder" in left._repr_html_()


def test_without_a_primitive_no_point_belongs_to_it() -> None:
    flat = np.random.default_rng(0).uniform(-1.0, 1.0, (100, 3)) * [1.0, 1.0, 0.0]
    found = primfit.fit(flat, kinds=["torus"])
    assert found.primitive is None
    assert not found.inliers.any() and np.isnan(found.residuals).all() and len(found.residuals) == 100


def test_a_point_that_is_missing_has_no_residual_and_is_not_drawn() -> None:
    with_gap = np.insert(POINTS, 5, np.nan, axis=0)
    found = FOUND.with_points(with_gap)
    assert np.isnan(found.residuals[5]) and not found.inliers[5] and len(found.inliers) == 301
    assert primfit.picture(found) == primfit.picture(FOUND)


@pytest.mark.parametrize("points", [POINTS, NOISE], ids=["fitted", "no fit"])
def test_a_notebook_shows_the_picture_of_the_report_and_the_words(points: np.ndarray) -> None:
    found = primfit.fit(points)
    shown = found._repr_html_()
    assert primfit.picture(found) in shown and found.message in shown
    root = ElementTree.fromstring(f"<body>{shown}</body>")
    assert root.find(".//{http://www.w3.org/2000/svg}svg") is not None


@pytest.mark.parametrize("kind", EXAMPLES)
def test_a_plot_has_all_points_colored_by_residual_and_the_outline_in_equal_scales(kind: str) -> None:
    points = noisy(EXAMPLES[kind], 400, 0.01)
    found = primfit.fit(points, kinds=[kind])
    axes = found.plot()
    dots = next(each for each in axes.collections if each.get_array() is not None and "Path3D" in repr(each))
    np.testing.assert_allclose(np.sort(dots.get_array()), np.sort(found.residuals))
    low, high = dots.get_clim()
    assert low == -high < 0.0
    assert len(axes.lines) > 0
    assert kind in axes.get_title() and axes.get_xlabel() == "x"
    in_mm = primfit.fit(points, kinds=[kind], unit="mm")
    assert " mm<" in primfit.picture(in_mm)
    assert in_mm.plot(axes).get_zlabel() == "z [mm]"
    matplotlib.pyplot.close(axes.figure)


def test_a_plot_goes_into_axes_that_are_given_and_has_bare_points_without_a_fit() -> None:
    from matplotlib import pyplot

    figure = pyplot.figure()
    axes = figure.add_subplot(projection="3d")
    found = primfit.fit(NOISE)
    assert found.status == "no_fit"
    assert found.plot(axes) is axes
    assert not axes.lines and len(axes.collections) == 1 and axes.get_title() == "no fit"
    pyplot.close(figure)


def test_a_plot_without_matplotlib_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ImportError, match=r'pip install "primfit\[plot\]"'):
        FOUND.plot()


def test_without_k3d_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "k3d", None)
    with pytest.raises(ImportError, match=r'pip install "primfit\[notebook\]"'):
        FOUND.show()
