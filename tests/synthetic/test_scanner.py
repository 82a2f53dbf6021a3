"""The virtual scanner: hidden sides empty, noise along the rays, shares and arcs as stated, truth true."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from primfit.fitting.names import KINDS
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.synthetic import RECIPES, ScannerRecipe, cloud, clouds
from primfit.synthetic import scanner as module
from primfit.synthetic.patches import Patch
from primfit.synthetic.recipes import Range
from primfit.synthetic.scanner import Window, cast, draw_patch, see, views_of
from primfit.synthetic.telling import bearable_noise, deviation

DEFAULT = RECIPES["scanner"]
CURVED = ("sphere", "cylinder", "cone", "torus")
CURVED_SPHERE = Sphere(np.zeros(3), 1.0)


@pytest.fixture(scope="module")
def drawn():
    return list(clouds(DEFAULT, 150))


def test_a_cloud_depends_on_recipe_and_index_only():
    forward = [cloud(DEFAULT, i) for i in range(6)]
    backward = [cloud(DEFAULT, i) for i in reversed(range(6))][::-1]
    other = [cloud(replace(DEFAULT, seed=1), i) for i in range(6)]
    for a, b, c in zip(forward, backward, other, strict=True):
        assert np.array_equal(a.points, b.points) and a.noise == b.noise
        assert not np.array_equal(a.points, c.points)


def test_kinds_take_turns_and_sizes_are_log_uniform(drawn):
    assert Counter(c.kind for c in drawn) == dict.fromkeys(KINDS, 30)
    sizes = np.log([len(c.points) for c in drawn])
    assert sizes.min() >= np.log(20) and sizes.max() <= np.log(20_000)
    middle = (np.log(20) + np.log(20_000)) / 2
    assert abs(sizes.mean() - middle) < 4 * np.log(1000) / np.sqrt(12 * 150)


def test_the_truth_fits_the_surface_points(drawn):
    for c in drawn:
        distance = c.primitive.signed_distance(c.points[~c.outliers])
        # The noise is along the ray: shorter across the surface. Rounding adds sqrt(3)/2 steps at most, and
        # coordinates of 5e6 carry 1e-9.
        allowed = 1.3 * c.noise + c.step + 1e-8
        assert np.sqrt(np.mean(distance**2)) < allowed


def test_what_is_recorded_has_its_range(drawn):
    with_noise = [c for c in drawn if c.noise]
    assert 0.88 < len(with_noise) / len(drawn) <= 1.0
    assert all(c.noise <= 0.02 * c.extent * (1 + 1e-9) for c in drawn)
    assert all(c.outlier_share == np.mean(c.outliers) <= 0.2 + 0.1 for c in drawn)
    assert np.mean([c.outlier_share == 0.0 for c in drawn]) > 0.2
    assert all((c.arc is None) == (c.kind == "plane") for c in drawn)
    assert all(0.0 <= c.arc <= 360.0 for c in drawn if c.arc is not None)
    assert {c.step > 0.0 for c in drawn} == {True, False}
    assert {len(c.stations) for c in drawn} == {1, 2, 3, 4}
    assert {c.correlation > 0.0 for c in drawn} == {True, False}
    assert all((c.station[c.outliers] == -1).sum() <= 0.2 * len(c.points) + 1 for c in drawn)
    assert max(np.abs(c.points).max() for c in drawn) > 1e5


def test_rounded_clouds_are_on_their_grid(drawn):
    millimetres = [c for c in drawn if c.step in (1e-3, 1.0)]
    singles = [c for c in drawn if c.step not in (0.0, 1e-3, 1.0)]
    assert millimetres and singles
    assert all(np.abs(c.points / c.step - np.round(c.points / c.step)).max() < 1e-3 for c in millimetres)
    assert all(np.array_equal(c.points, c.points.astype(np.float32)) for c in singles)
    assert all(c.step <= 0.005 * c.extent for c in drawn)


@pytest.mark.parametrize("kind", CURVED)
def test_hidden_sides_are_empty(kind, monkeypatch):
    """Every point of a solid faces its station, and no part of the object lies before it."""
    monkeypatch.setattr(module, "MODES", (("solid", 1.0),))
    rng = np.random.default_rng(1)
    for _ in range(4):
        patch, views = views_of(rng, ScannerRecipe(whole=1.0), kind, 500)
        for view in views:
            sight = view.origin - view.points
            assert np.einsum("ij,ij->i", patch.primitive.gradient(view.points), sight).min() > 0.0
            if kind == "cone":
                continue
            # A walk from the station to just before the point stays outside.
            before = view.origin + np.linspace(0, 0.999, 300)[:, None, None] * -sight[:50]
            inside = patch.primitive.signed_distance(before.reshape(-1, 3)) < -1e-3
            assert not (inside & patch.between_ends(before.reshape(-1, 3))).any()


def test_two_solid_halves_are_seen_from_two_sides_only():
    tube = Patch(Cylinder(np.array([0, 0, 1.0]), np.zeros(3), 1.0), (-np.pi, np.pi), (-1.0, 1.0))
    window = Window(np.array([9.0, 0, 0]), np.diag([-1.0, -1.0, 1.0]), (-0.2, 0.2), (-0.2, 0.2))
    view = cast(tube, "solid", window, 40, 40)
    assert view.points[:, 0].min() > 0.0
    # Visible are the azimuths with cos > radius / distance.
    assert np.cos(np.arctan2(view.points[:, 1], view.points[:, 0])).min() > 1 / 9


def test_density_falls_with_range_and_incidence():
    """A floor seen from height h has h / distance^3 rays per area, where rays are equally dense in all
    directions; equal angles make them denser by 1 / cos(elevation) = distance / x."""
    floor = Patch(Plane(np.array([0, 0, 1.0]), np.zeros(3)), (1.0, 9.0), (-0.5, 0.5))
    window = Window(np.array([0, 0, 3.0]), np.eye(3), (-0.6, 0.6), (-1.4, -0.2))
    view = cast(floor, "shell", window, 600, 300)
    x, y, _ = view.points.T
    for near, far in ((1.5, 3.0), (3.0, 6.0)):
        counts = [np.count_nonzero((np.abs(x - at) < 0.3) & (np.abs(y) < 0.3)) for at in (near, far)]
        expected = (far**2 + 9) * far / ((near**2 + 9) * near)
        # The squares are 0.6 wide: the density varies within.
        assert counts[0] / counts[1] == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize("kind", KINDS)
def test_noise_is_along_the_ray(kind):
    quiet = ScannerRecipe(noise=Range(1e-12, 1e-12), noiseless=0.0, decidable=False)
    loud = replace(quiet, noise=Range(0.01, 0.01))
    for seed in range(3):
        clean, noisy = (see(np.random.default_rng(seed), recipe, kind, 3000) for recipe in (quiet, loud))
        real = ~noisy.mixed
        shift = (noisy.points - clean.points)[real]
        ray = (clean.points - clean.stations[clean.station])[real]
        assert np.linalg.norm(np.cross(shift, ray), axis=1).max() < 1e-9 * np.linalg.norm(ray, axis=1).max()
        along = np.einsum("ij,ij->i", shift, ray) / np.linalg.norm(ray, axis=1)
        assert noisy.noise == pytest.approx(0.01 * noisy.extent)
        # 3,000 points, correlated over at most 8 x 8 rays, with weights: a quarter.
        assert np.sqrt(np.mean(along**2)) == pytest.approx(noisy.noise, rel=0.25)


def test_mixed_pixels_lie_behind_the_edge(monkeypatch):
    monkeypatch.setattr(module, "MIXED_CLOUDS", 1.0)
    recipe = ScannerRecipe(noise=Range(1e-12, 1e-12), noiseless=0.0, stations=1)
    sight = see(np.random.default_rng(3), recipe, "plane", 2000)
    assert 0.0 < sight.mixed.mean() <= 0.1
    height = np.abs(sight.points[:, 2])
    assert height[~sight.mixed].max() < 1e-9
    away = np.linalg.norm(sight.points - sight.stations[0], axis=1)
    straight = (sight.points - sight.stations[0]) / away[:, None]
    surface = -sight.stations[0, 2] / straight[:, 2]
    behind = (away - surface)[sight.mixed]
    assert behind.min() >= -1e-9 and behind.max() <= 0.2 * sight.extent


@pytest.mark.parametrize("share", [0.0, 0.15, 0.6])
def test_the_share_of_outliers_is_as_stated(share, monkeypatch):
    monkeypatch.setattr(module, "MIXED_CLOUDS", 0.0)
    recipe = ScannerRecipe(outliers=Range(share, share), without_outliers=0.0, points=Range(100, 2000))
    for c in clouds(recipe, 15):
        assert abs(c.outlier_share - share) <= 1.0 / len(c.points)
        assert np.array_equal(c.outliers, c.station == -1)


@pytest.mark.parametrize("kind", CURVED)
def test_arcs_are_as_stated(kind):
    recipe = ScannerRecipe(
        kinds=(kind,),
        arc=Range(50.0, 50.0),
        whole=0.0,
        noiseless=1.0,
        points=Range(500, 900),
        decidable=False,
    )
    arcs = [c.arc for c in clouds(recipe, 12)]
    assert max(arcs) <= 50.0 + 1e-6
    assert max(arcs) > 45.0
    whole = [c.arc for c in clouds(replace(recipe, whole=1.0, stations=4), 12)]
    assert max(whole) > 300.0


def test_the_arc_is_that_of_the_points():
    recipe = ScannerRecipe(kinds=("cylinder",), noiseless=1.0, without_outliers=1.0, points=Range(500, 900))
    for c in clouds(recipe, 20):
        if c.step or c.outlier_share or np.abs(c.points).max() > 1e4 * c.extent:
            continue
        tube = c.primitive
        across = np.linalg.svd(tube.axis[None])[2][1:]
        x, y = across @ (c.points - tube.point).T
        azimuth = np.sort(np.arctan2(y, x))
        gap = np.diff(azimuth, append=azimuth[0] + 2 * np.pi).max()
        assert c.arc == pytest.approx(360 - np.degrees(gap), abs=1e-4)


def test_parameters_span_their_ranges():
    rng = np.random.default_rng(2)
    pieces = {kind: [draw_patch(rng, DEFAULT, kind) for _ in range(400)] for kind in KINDS}
    angles = np.degrees([piece.primitive.half_angle for piece in pieces["cone"]])
    ratios = [piece.primitive.major_radius for piece in pieces["torus"]]
    lengths = [piece.v[1] - piece.v[0] for piece in pieces["cylinder"]]
    arcs = np.degrees([piece.u[1] - piece.u[0] for piece in pieces["cylinder"]])
    assert 2.0 <= angles.min() < 2.2 and 75 < angles.max() <= 80
    assert 1.1 <= min(ratios) < 1.2 and 18 < max(ratios) <= 20
    assert 0.3 <= min(lengths) < 0.35 and 14 < max(lengths) <= 15
    assert 30 <= arcs.min() < 32
    # Four standard deviations of a share among 400; log-uniform between 30 and 360 degrees.
    assert abs(np.mean(arcs == 360.0) - 0.4) < 0.1
    assert abs(np.median(arcs[arcs < 360.0]) - np.sqrt(30 * 360)) < 25


def test_noise_never_hides_the_kind():
    for index, kind in enumerate(CURVED * 5):
        sight = see(np.random.default_rng(index), ScannerRecipe(noise=Range(0.02, 0.02)), kind, 200)
        assert sight.noise <= sight.tolerable
    # A patch of a sphere that is nearly flat bears little noise, one that is not bears more.
    flat, bent = (Patch(CURVED_SPHERE, (-np.pi, np.pi), (0.0, angle)) for angle in (0.1, 1.0))
    rng = np.random.default_rng(0)
    flat_one, bent_one = deviation(flat, flat.sample(rng, 400)), deviation(bent, bent.sample(rng, 400))
    assert 10 * flat_one < bent_one
    assert bearable_noise(1.0, 64) == pytest.approx(1 / 1.5)


def test_decidable_clouds_have_points_enough(drawn):
    assert all(np.count_nonzero(c.station >= 0) >= 6 * c.primitive.dof for c in drawn)


def test_hard_clouds_are_harder():
    hard = list(clouds(RECIPES["scanner-hard"], 60))
    assert max(c.outlier_share for c in hard) > 0.5
    assert min(c.arc for c in hard if c.arc is not None) < 20
    assert min(len(c.points) for c in hard) < 40


def test_large_clouds():
    recipe = replace(RECIPES["scanner-large"], points=Range(300_000, 300_000))
    assert len(cloud(recipe, 2).points) == 300_000


@pytest.mark.slow
def test_a_million_points_of_each_kind():
    recipe = replace(RECIPES["scanner-large"], points=Range(1_000_000, 1_000_000))
    assert all(len(c.points) == 1_000_000 for c in clouds(recipe, 5))


@pytest.mark.parametrize(
    "options",
    [
        {"kinds": ("cube",)},
        {"seed": -1},
        {"points": Range(2, 5)},
        {"outliers": Range(0.5, 1.0)},
        {"arc": Range(0, 400)},
    ],
)
def test_recipes_refuse_what_makes_no_sense(options):
    with pytest.raises(ValueError, match="must"):
        ScannerRecipe(**options)


def test_few_rays_are_cast_for_a_point(monkeypatch):
    """What a thousand clouds a minute rest on; `primfit bench drawing` times them."""
    rays = 0

    def counted(patch, mode, window, rows, columns):
        nonlocal rays
        rays += rows * columns
        return cast(patch, mode, window, rows, columns)

    monkeypatch.setattr(module, "cast", counted)
    n_points = sum(len(c.points) for c in clouds(replace(DEFAULT, seed=3), 60))
    assert n_points < rays < 10 * n_points
