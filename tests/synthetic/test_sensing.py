"""Clouds of sensors: as the recipe says, true to their surface, and each sensor with its own errors."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from primfit.fitting.names import KINDS
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.torus import Torus
from primfit.synthetic import RECIPES, SensorRecipe, cloud, clouds, sensing
from primfit.synthetic.clouds import MOVES, SHARES
from primfit.synthetic.deciding import MOST_NOISE, decidable
from primfit.synthetic.parts import ELBOW_RATIO, HALF_ANGLE, RIM_RATIO, draw_part
from primfit.synthetic.recipes import SENSORS, Range
from primfit.synthetic.sensing import (
    FEWEST_RINGS,
    UndecidableError,
    erred,
    form_tolerance,
    told_scene,
    vertices,
)
from primfit.synthetic.sensors import SENSORS as KNOWN

FEW = replace(RECIPES["sensor"], share_of_many=0.0, points=Range(50, 5000))
"""Without large clouds, which take seconds."""


@pytest.fixture(scope="module")
def drawn():
    return list(clouds(FEW, 100))


def scene(sensor, kind, seed=0, count=1000):
    return told_scene(np.random.default_rng(seed), SensorRecipe(sensors=(sensor,)), kind, count)


def test_a_cloud_depends_on_recipe_and_index_only():
    forward = [cloud(FEW, i) for i in range(5)]
    backward = [cloud(FEW, i) for i in reversed(range(5))][::-1]
    for a, b, c in zip(forward, backward, clouds(replace(FEW, seed=1), 5), strict=True):
        assert np.array_equal(a.points, b.points) and a.effects == b.effects and a.sensor == b.sensor
        assert not np.array_equal(a.points, c.points)


def test_kinds_take_turns_and_sizes_are_log_uniform(drawn):
    assert Counter(c.kind for c in drawn) == dict.fromkeys(KINDS, 20)
    sizes = np.log([len(c.points) for c in drawn])
    assert sizes.min() >= np.log(50) and sizes.max() <= np.log(5000)
    assert abs(sizes.mean() - np.log(500)) < 4 * np.log(100) / np.sqrt(12 * 100)


def test_one_cloud_in_twenty_is_large():
    default = RECIPES["sensor"]
    assert isinstance(default, SensorRecipe) and default.share_of_many == 0.05
    assert (default.points.low, default.many.high) == (50, 200_000)
    large = cloud(replace(default, share_of_many=1.0, many=Range(30_000, 30_000)), 2)
    assert len(large.points) == 30_000


def test_the_truth_fits_the_surface_points(drawn):
    for c in drawn:
        off = np.abs(c.primitive.signed_distance(c.points[~c.outliers]))
        # Rounding adds sqrt(3) / 2 steps at most, and coordinates of 5e6 carry 1e-9.
        assert np.sqrt(np.mean(off**2)) == pytest.approx(c.noise, rel=0.25, abs=1e-8)
        assert np.quantile(off, 0.95) < 3.0 * c.noise + c.step + 1e-8
        assert c.noise < 2.0 * MOST_NOISE * c.extent


def test_what_is_recorded_is_there(drawn):
    assert {c.sensor for c in drawn} == set(SENSORS)
    assert {c.family for c in drawn} == {"sensor"}
    for c in drawn:
        assert c.outlier_share == np.mean(c.outliers)
        assert sum(c.effects.get(name, 0.0) for name in SHARES) >= c.outlier_share - 1e-9
        assert set(c.effects) <= {*MOVES, *SHARES}
        assert c.effects[c.largest_effect] == max(c.effects[name] for name in MOVES if name in c.effects)
        lengths = [size for name, size in c.effects.items() if name not in SHARES]
        assert 0.0 < max(lengths) < 0.2 * c.extent
        assert (c.arc is None) == (c.kind == "plane") and (c.stations is None) == (c.sensor == "contact")
        assert (c.field_range is None) == (c.sensor == "contact")
    names = {name for c in drawn for name in c.effects}
    assert names >= {"white", "rough", "self-affine", "form", "radial bow", "edge fringe", "comet tail"}


def test_files_are_rounded_where_that_is_below_the_noise(drawn):
    steps = {c.step for c in drawn}
    assert 0.0 in steps and len(steps) > 5
    assert all(c.step <= 0.7 * c.noise for c in drawn)
    on_grid = [c for c in drawn if c.step in (1e-3, 1e-4, 1e-5, 0.1, 0.01, 1.0)]
    assert on_grid
    for c in on_grid:
        assert np.abs(c.points / c.step - np.round(c.points / c.step)).max() < 1e-2


def test_every_sensor_of_the_recipe_is_described():
    assert tuple(KNOWN) == SENSORS
    with pytest.raises(ValueError, match="sensors must be some of"):
        SensorRecipe(sensors=("crystal ball",))


@pytest.mark.parametrize("name", SENSORS)
def test_every_sensor_sees_a_cylinder_that_can_be_told(name):
    made = scene(name, "cylinder", seed=3, count=400)
    assert made.sensor == name and len(made.seen.points) == 400
    assert decidable(np.random.default_rng(0), made.patch, made.seen, made.effects)
    assert np.abs(made.patch.primitive.signed_distance(made.seen.points)).max() < 1e-9 * made.seen.extent
    assert np.sqrt(np.mean(made.seen.weight**2)) == pytest.approx(1.0)
    if name != "contact":
        assert made.seen.cosine.min() >= np.cos(np.radians(KNOWN[name].steepest))
    points, mixed, sizes = erred(np.random.default_rng(1), made)
    off = made.patch.primitive.signed_distance(points[~mixed])
    assert 0.2 * made.noise < np.sqrt(np.mean(off**2)) < 3.0 * made.noise
    assert set(sizes) >= {effect.name for effect in made.effects}


def test_what_cannot_be_told_is_said(monkeypatch):
    monkeypatch.setattr(sensing, "decidable", lambda *given: False)
    monkeypatch.setattr(sensing, "MOST_SENSORS", 2)
    with pytest.raises(UndecidableError, match="no cone of 40 points can be told by any of contact"):
        scene("contact", "cone", count=40)


def test_a_spinning_laser_sees_a_few_rings_each_off_by_its_own():
    made = scene("spinning", "plane", seed=1)
    assert FEWEST_RINGS <= len(np.unique(made.seen.line)) < 60
    points, mixed, sizes = erred(np.random.default_rng(0), made)
    assert sizes["line offsets"] > 0.1 * made.noise
    off = np.einsum("ij,ij->i", points - made.seen.points, made.seen.rays)[~mixed]
    line = made.seen.line[~mixed]
    means = [off[line == i].mean() for i in np.unique(line) if np.count_nonzero(line == i) > 20]
    assert np.std(means) > 0.1 * made.noise


def test_vertices_of_a_fused_mesh_are_nearly_regular():
    """The distance to the nearest neighbour varies less than the 0.52 of random points."""
    made = scene("fused mesh", "plane", seed=2)
    apart = np.linalg.norm(made.seen.points[:, None] - made.seen.points, axis=2)
    nearest = np.sort(apart, axis=1)[:, 1]
    assert np.std(nearest) / np.mean(nearest) < 0.4
    few = vertices(made.seen, 200)
    assert len(few) == pytest.approx(200, rel=0.15)


def test_contact_machines_go_round_on_rings():
    made = scene("contact", "cylinder", seed=4)
    heights = np.unique(np.round(made.seen.points[:, 2], 12))
    assert 3 <= len(heights) <= 8


def test_two_stations_are_off_by_about_a_noise():
    shifts = []
    for seed in range(40):
        made = scene("terrestrial", "plane", seed=seed, count=200)
        shifts += [effect.size / made.noise for effect in made.effects if effect.name == "station shift"]
    assert len(shifts) > 8 and 0.0 < min(shifts) and max(shifts) <= 2.0


def test_parts_have_the_proportions_of_their_laws():
    rng = np.random.default_rng(0)
    for kind in KINDS:
        for _ in range(60):
            patch, mode = draw_part(rng, kind, 0.3)
            points = patch.sample(rng, 300)
            assert np.linalg.norm(np.ptp(points, axis=0)) == pytest.approx(0.3, rel=0.1)
            assert mode in ("solid", "shell", "hollow")
            match patch.primitive:
                case Cone(half_angle=half_angle):
                    assert HALF_ANGLE.low <= np.degrees(half_angle) <= HALF_ANGLE.high
                    assert RIM_RATIO.low <= patch.v[1] / patch.v[0] <= RIM_RATIO.high
                case Torus(major_radius=major_radius, minor_radius=minor_radius):
                    assert ELBOW_RATIO.low <= major_radius / minor_radius <= ELBOW_RATIO.high


def test_form_tolerances_are_those_of_the_standards():
    assert form_tolerance(1.0) == pytest.approx(0.004) and form_tolerance(4.0) == pytest.approx(0.010)
    assert form_tolerance(0.1) == pytest.approx(0.0004)
    sizes = np.geomspace(0.005, 20.0, 30)
    assert (np.diff([form_tolerance(size) for size in sizes]) >= 0.0).all()
