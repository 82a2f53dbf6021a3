"""Answers show themselves as 3D pictures in a notebook."""

import pickle
from typing import Any

import numpy as np
import pytest

import primfit
from primfit.app.exports import notebook
from primfit.app.exports.colors import color_limit, diverging
from primfit.fitting.answer.residuals import Residuals
from primfit.fitting.geometry.vectors import Array
from tests.fitting.clouds import EXAMPLES, noisy
from tests.paths import ROOT

POINTS = noisy(EXAMPLES["cylinder"], 300, 0.01)
POINTS[7] += 3.0
FOUND = primfit.fit(POINTS)


@pytest.fixture(autouse=True, scope="module")
def _k3d() -> None:
    pytest.importorskip("k3d", reason="needs the extra notebook: pip install 'primfit[notebook]'")


def drawn(plot: Any) -> dict[str, Any]:
    """What is in the picture, by name; the last of the edges stands for all."""
    return {each.name: each for each in plot.objects}


def n_shown(shown: dict[str, Any]) -> int:
    """How many points are in the picture."""
    return sum(len(shown[name].positions) for name in ("points", "outliers") if name in shown)


def world(each: Any, local: Array) -> Array:
    """Places (N, 3) in the coordinates of the input."""
    matrix = np.asarray(each.model_matrix, np.float64)
    return np.asarray(local, np.float64).reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]


@pytest.mark.parametrize("kind", EXAMPLES)
def test_points_lie_where_they_are_and_the_surface_on_the_primitive(kind: str) -> None:
    points = noisy(EXAMPLES[kind], 400, 0.01)
    found = primfit.fit(points, kinds=[kind])
    shown = drawn(found.show())
    size = np.ptp(points, axis=0).max()
    dots = world(shown["points"], shown["points"].positions)
    assert dots == pytest.approx(points[found.inliers], abs=1e-6 * size)
    surface = shown[kind]
    assert len(surface.indices) > 0 and surface.indices.max() < len(surface.vertices)
    distance = found.primitive.signed_distance(world(surface, surface.vertices))
    assert np.abs(distance).max() < 1e-5 * size
    assert 0.0 < surface.opacity < 1.0 and surface.color == notebook.SURFACE


def test_colors_are_those_of_the_exported_residuals() -> None:
    dots = drawn(FOUND.show())["points"]
    residuals = primfit.residuals(FOUND)
    low, high = dots.color_range
    assert (-low, high) == pytest.approx([color_limit(residuals)] * 2)
    share = np.clip((np.asarray(dots.attribute, np.float64) - low) / (high - low), 0.0, 1.0)
    place, *channels = np.asarray(dots.color_map, np.float64).reshape(-1, 4).T
    colors = np.stack([np.interp(share, place, channel) for channel in channels], axis=1) * 255.0
    expected = diverging(residuals.distance[residuals.inlier], high)
    # Half a step of the rounding to whole numbers, and what float32 takes away.
    assert np.abs(colors - expected).max() < 0.51
    blue, red = dots.attribute < -high / 2.0, dots.attribute > high / 2.0
    assert blue.any() and red.any()
    assert (colors[blue, 2] > colors[blue, 0]).all() and (colors[red, 0] > colors[red, 2]).all()


def test_an_outlier_is_set_apart() -> None:
    shown = drawn(FOUND.show())
    assert len(shown["points"].positions) == 299
    outlier = shown["outliers"]
    assert world(outlier, outlier.positions) == pytest.approx(POINTS[[7]], abs=1e-5)
    assert outlier.color == notebook.APART and outlier.point_size > shown["points"].point_size
    assert "orange: 1 outlier" in shown["legend"].text


def test_points_far_from_the_origin_keep_their_digits() -> None:
    far = np.array([4e5, 5.5e6, 100.0])
    found = primfit.fit(POINTS + far, unit="m")
    shown = drawn(found.show())
    dots = shown["points"]
    assert world(dots, dots.positions) - far == pytest.approx(POINTS[found.inliers], abs=1e-6)
    assert "[m]" in shown["legend"].text


def test_the_camera_looks_at_the_inliers_and_not_at_one_point_far_away() -> None:
    points = POINTS.copy()
    points[7] += 1e4
    near = POINTS[FOUND.inliers]
    *place, x, y, z = primfit.fit(points).show().camera[:6]
    assert np.all(np.abs(np.array([x, y, z]) - near.mean(axis=0)) < np.ptp(near, axis=0).max())
    assert np.linalg.norm(np.subtract(place, [x, y, z])) < 3.0 * np.linalg.norm(np.ptp(near, axis=0))


def test_no_fit_shows_the_best_try_in_another_color() -> None:
    found = primfit.fit(np.random.default_rng(0).uniform(size=(500, 3)))
    assert found.status == "no_fit" and found.primitive is not None
    shown = drawn(found.show())
    kind = found.primitive.kind
    assert f"no fit, best try: {kind}" in shown["legend"].text
    assert shown[kind].color == notebook.BEST_TRY
    assert n_shown(shown) == 500


def test_without_a_primitive_the_points_are_shown_alone() -> None:
    flat = np.random.default_rng(0).uniform(-1.0, 1.0, (100, 3)) * [1.0, 1.0, 0.0]
    shown = drawn(primfit.fit(flat, kinds=["torus"]).show())
    assert list(shown) == ["points without a primitive", "legend"]
    assert len(shown["points without a primitive"].positions) == 100
    assert shown["legend"].text == "no fit"


def test_an_ambiguous_answer_shows_its_first_kind_and_says_so() -> None:
    found = primfit.fit(ROOT / "samples" / "short-arc.csv")
    shown = drawn(found.show())
    assert "ambiguous, first: cylinder<br>colors: signed distance [mm]" in shown["legend"].text
    assert "cylinder" in shown and "plane" not in shown


def test_without_extents_there_is_no_surface() -> None:
    assert list(drawn(primfit.fit(POINTS, include=()).show())) == ["points", "outliers", "legend"]


def test_of_many_points_a_sample_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notebook, "MOST_POINTS", 100)
    assert n_shown(drawn(FOUND.show())) == 100


def test_points_may_be_given_again() -> None:
    left = pickle.loads(pickle.dumps(FOUND))
    with pytest.raises(primfit.InvalidOptionError, match=r"points are missing.*with_points gives them again"):
        left.show()
    assert n_shown(drawn(primfit.show(left, POINTS))) == 300


def test_segments_are_one_picture_with_one_scale_of_colors() -> None:
    segments = primfit.fit_segments(primfit.read(ROOT / "samples" / "plant.csv", labels="segment"))
    shown = drawn(segments.show())
    assert {"1 plane", "2 cylinder", "3 sphere", "4 cone"} <= shown.keys()
    assert n_shown(shown) == sum(len(segment.rows) for segment in segments) == 3800
    distance, inlier = (
        np.concatenate([getattr(segment.recognition, name) for segment in segments])
        for name in ("residuals", "inliers")
    )
    assert shown["points"].color_range[1] == pytest.approx(color_limit(Residuals(distance, inlier)))
    assert "4 segments" in shown["legend"].text


def test_segments_without_an_answer_are_left_out() -> None:
    labels = np.array(["pipe"] * 300 + ["stray"] * 2)
    segments = primfit.fit_segments(np.vstack([POINTS, POINTS[:2]]), labels)
    assert "1 segment<br>" in drawn(segments.show())["legend"].text
    with pytest.raises(primfit.NothingToExportError, match="no segment"):
        primfit.show_segments(segments[1:])
