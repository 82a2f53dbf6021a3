"""Pictures of a report: far points do not squeeze them, labels do not overlap, no line is out of place."""

import re
from itertools import pairwise

import numpy as np
import pytest

import primfit
from primfit.app.exports.fitted import Fitted, fitted_points
from primfit.app.exports.report.histogram import histogram
from primfit.app.exports.report.scene import Camera, Scene
from primfit.app.exports.report.svg import FONT, Axis
from primfit.app.exports.report.unrolled import unrolled_map
from primfit.app.exports.report.views import SIZE, STRIP, VIEWS, lone_view, triad, views
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive

PIPE = Cylinder([0.3, -0.5, 0.8], [10.0, 20.0, 30.0], 8.0)
PLATE = Plane([0.3, -0.5, 0.8], [10.0, 20.0, 30.0])
Ends = tuple[float, float]
LETTER = 0.6 * FONT
"""About how wide one is."""


def _near(
    primitive: Primitive, u: tuple[float, float], v: tuple[float, float], n: int, noise: float
) -> Array:
    rng = np.random.default_rng(5)
    return primitive.surface(rng.uniform(*u, n), rng.uniform(*v, n)) + rng.normal(0.0, noise, (n, 3))


def _fitted(points: Array, kind: str) -> Fitted:
    return fitted_points(primfit.fit(points, kinds=[kind]), points)


def _places(picture: str, class_: str) -> Array:
    """The corners of all paths of a class, which are a place and steps from there."""
    corners = []
    for start, steps in re.findall(rf'd="M([-\d ]+)l([-\d ]+)" class="{class_}"', picture):
        moves = np.array([start.split(), *np.array(steps.split()).reshape(-1, 2)], float)
        corners.append(np.cumsum(moves, axis=0))
    return np.concatenate(corners)


@pytest.mark.parametrize(("surface", "kind"), [(PIPE, "cylinder"), (PLATE, "plane")])
def test_stray_points_leave_the_scene_its_size_and_are_counted(surface: Primitive, kind: str) -> None:
    near = _near(surface, (0.0, 6.0), (-7.0, 11.0), 1900, 0.01)
    far = near.mean(axis=0) + np.random.default_rng(1).normal(0.0, 3000.0, (100, 3))
    scene = Scene.of(_fitted(np.vstack([near, far]), kind))
    view = lone_view(scene, 0.03, "mm")
    assert np.ptp(_places(view, "edge"), axis=0).max() > 0.8 * SIZE
    beyond = re.search(r">(\d+) points beyond<", view)
    assert beyond and 95 <= int(beyond[1]) <= 100
    assert 'class="ring"' in view and 'class="ring"' not in lone_view(
        Scene.of(_fitted(near, kind)), 0.03, "mm"
    )


def test_without_a_primitive_stray_points_do_not_squeeze_the_others() -> None:
    near = np.random.default_rng(0).normal(0.0, 1.0, (500, 3))
    points = np.vstack([near, near[:20] + np.array([4e5, 0.0, 0.0])])
    recognition = primfit.fit(points, include=[])
    view = lone_view(Scene.of(fitted_points(recognition, points)), 0.0, None)
    assert ">20 points beyond<" in view


def test_a_few_far_residuals_do_not_squeeze_the_histogram() -> None:
    distance = np.append(np.random.default_rng(0).normal(0.0, 0.01, 1000), [3.0, -4.0, 900.0])
    picture = histogram(distance, 0.02, "mm")
    assert picture.count('class="bar"') > 15 and "3 points beyond the scale" in picture
    assert "signed residual [µm]" in picture
    assert "beyond" not in histogram(distance[:1000], 0.02, "mm")


def test_inliers_far_along_the_surface_do_not_squeeze_the_map() -> None:
    near = _near(PIPE, (0.0, 6.28), (-7.0, 11.0), 1000, 0.001)
    far = PIPE.surface(np.array([1.0, 2.0]), np.array([300.0, -400.0]))
    fitted = _fitted(np.vstack([near, far]), "cylinder")
    assert fitted.residuals.inlier[-2:].all()
    picture = unrolled_map(fitted, 0.03, "mm")
    assert "2 points beyond the map" in picture and ">15<" in picture


def test_a_narrow_map_is_stretched_and_says_so() -> None:
    rod = Cylinder([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 0.05)
    picture = unrolled_map(_fitted(_near(rod, (0.0, 6.28), (0.0, 40.0), 500, 0.001), "cylinder"), 0.01, "mm")
    assert "arc length around the axis [mm], stretched" in picture
    height = int(re.findall(r'height="(\d+)" class="frame"', picture)[0])
    assert height > 4 * FONT


@pytest.mark.parametrize("room", [1100.0, 4400.0])
@pytest.mark.parametrize(
    ("low", "high"),
    [
        (1234567.891, 1234567.991),
        (-1234567.891, 1234567.991),
        (0.0, 1.0),
        (-3e-17, 5e-17),
        (150723.6, 150741.9),
        (0.0, 0.0234),
        (-5432109.876, -5432109.871),
        (1e90, 3e90),
    ],
)
def test_labels_of_an_axis_neither_overlap_nor_repeat(low: float, high: float, room: float) -> None:
    axis = Axis.of(low, high, room)
    assert axis.values and len(set(axis.labels)) == len(axis.labels)
    place = (np.array(axis.values) - low) / (high - low) * room
    ends = [
        (x - len(label) * LETTER / 2, x + len(label) * LETTER / 2)
        for x, label in zip(place, axis.labels, strict=True)
    ]
    assert all(after > before for (_, before), (after, _) in pairwise(ends))
    base = float(axis.less.replace(",", "")) if axis.less else 0.0
    step = (high - low) / max(len(axis.values), 1)
    for value, label in zip(axis.values, axis.labels, strict=True):
        assert base + float(label) == pytest.approx(value, abs=0.01 * step)


def test_what_labels_leave_out_stands_in_the_name_of_the_axis() -> None:
    axis = Axis.of(1234567.891, 1234567.991, 4400.0)
    assert axis.named("height", "mm").startswith("height \u2212 1,234,567.9") and axis.labels[0].startswith(
        "0.0"
    )
    assert Axis.of(-5432109.876, -5432109.871, 4400.0).named("height", "").startswith("height + 5,432,109.87")


def test_an_axis_far_away_is_not_drawn_across_the_surface() -> None:
    almost_flat = Cylinder([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 2000.0)
    points = _near(almost_flat, (0.0, 0.02), (-7.0, 11.0), 1000, 0.001)
    assert 'class="axis"' not in views(Scene.of(_fitted(points, "cylinder")), 0.01, "mm")
    assert 'class="axis"' in views(
        Scene.of(_fitted(_near(PIPE, (0.0, 3.0), (-7.0, 11.0), 500, 0.01), "cylinder")), 0.01, "mm"
    )


def test_edges_of_a_deep_surface_are_not_hidden_by_itself() -> None:
    funnel = Cone([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.1)
    points = _near(funnel, (0.0, 1.0), (3.0, 60.0), 1000, 0.001)
    *_, above = views(Scene.of(_fitted(points, "cone")), 0.01, "mm").split("<figure>")
    assert "from above" in above and 'class="edge"' in above and "edge behind" not in above


def _apart(place: Array, line: Array) -> float:
    """Distance from the middle of a letter to a line of two ends."""
    start, along = line[0], line[1] - line[0]
    at = np.clip((place - start) @ along / (along @ along), 0.0, 1.0)
    return float(np.linalg.norm(place - start - at * along))


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("view", VIEWS, ids=lambda view: str(view[0]))
def test_names_of_axes_are_free_of_each_other_and_of_all_lines(
    view: tuple[str, float, float], seed: int
) -> None:
    for axes in np.linalg.qr(np.random.default_rng(seed).normal(size=(50, 3, 3)))[0]:
        drawn = triad(Camera.at(axes[0], axes[1], *view[1:]))
        letters = np.array(re.findall(r'<text x="(\d+)" y="(\d+)"', drawn), float) - [0.0, 45.0]
        corners = _places(drawn, "line").reshape(-1, 2, 2)
        assert len(letters) == len(corners) >= 2
        for i, letter in enumerate(letters):
            assert 0.0 < letter[0] - 50.0 and letter[0] + 50.0 < SIZE
            assert letter[1] + 45.0 <= SIZE + STRIP
            assert min(_apart(letter, line) for line in corners) > 70.0
            assert min(np.linalg.norm(letters[:i] - letter, axis=1), default=200.0) > 105.0


def test_an_axis_to_the_viewer_has_no_name() -> None:
    drawn = triad(Camera.at(np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), 0.0, 0.0))
    assert re.findall(r">([xyz])<", drawn) == ["y", "z"]
