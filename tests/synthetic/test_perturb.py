"""The laws of noise, removal and bumps, by statistics over many draws."""

import numpy as np
import pytest

from primfit.fitting.names import KINDS
from primfit.synthetic import PERTURBATIONS, sample_cloud
from primfit.synthetic.perturb import (
    FEWEST_POINTS,
    TYPES,
    add_bump,
    add_noise,
    diagonal,
    gaussian_noise,
    perturb,
    undersampled,
    uniform_noise,
    without_part,
)
from primfit.synthetic.recipes import NoiseLaw

GRID = np.stack(np.meshgrid(np.linspace(-2, 2, 60), np.linspace(-1, 1, 60), [0.5]), axis=-1).reshape(-1, 3)


def test_uniform_noise_fills_its_interval_on_each_coordinate():
    noise = uniform_noise(np.random.default_rng(0), 30_000, 5)
    assert np.abs(noise).max() <= 0.2
    assert (np.abs(noise).max(axis=0) > 0.199).all()
    # sd of U(-a, a) is a / sqrt 3; sampling error of the mean 7e-4, of the sd below 0.5 %.
    np.testing.assert_allclose(noise.mean(axis=0), 0.0, atol=4e-3)
    np.testing.assert_allclose(noise.std(axis=0), 0.2 / np.sqrt(3), rtol=0.02)


def test_gaussian_noise_is_biased_as_in_the_benchmark():
    noise = gaussian_noise(np.random.default_rng(1), 30_000, 10)
    np.testing.assert_allclose(noise.mean(axis=0), -0.1, atol=5e-3)
    np.testing.assert_allclose(noise.std(axis=0), 0.2, rtol=0.02)
    assert abs(np.corrcoef(noise.T) - np.eye(3)).max() < 0.03


@pytest.mark.parametrize("noise", ["uniform", "gaussian"])
def test_noise_moves_a_random_share_and_leaves_the_rest_exact(noise):
    rng = np.random.default_rng(2)
    shares = []
    for _ in range(200):
        noisy, moved = add_noise(rng, GRID, NoiseLaw(), noise)
        assert np.array_equal(noisy[~moved], GRID[~moved])
        assert (noisy[moved] != GRID[moved]).all()
        if noise == "uniform":
            assert np.abs(noisy - GRID).max() <= 1 / 3
        shares.append(moved.mean())
    # A whole number of points is moved, up to one fewer than the share says.
    assert 0.3 - 1 / len(GRID) <= min(shares) < 0.34
    assert 0.76 < max(shares) <= 0.8
    assert abs(np.mean(shares) - 0.55) < 4 * 0.5 / np.sqrt(12 * 200)


def test_planes_get_larger_amplitudes():
    def largest(kind):
        rng = np.random.default_rng(3)
        return max(np.abs(perturb(rng, GRID, kind, "A1")[0] - GRID).max() for _ in range(200))

    assert 0.9 < largest("plane") <= 1.0
    assert 0.3 < largest("sphere") <= 1 / 3


def test_undersampling_keeps_a_random_subset():
    sizes = [int(undersampled(np.random.default_rng(seed), 1000).sum()) for seed in range(200)]
    assert 200 <= min(sizes) and max(sizes) <= 500
    assert abs(np.mean(sizes) - 350) < 4 * 300 / np.sqrt(12 * 200)
    assert undersampled(np.random.default_rng(0), 80).sum() >= FEWEST_POINTS


def test_a_missing_part_is_a_ball_about_a_point():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        kept = without_part(rng, GRID)
        center = GRID[np.random.default_rng(seed).integers(len(GRID))]
        distance = np.linalg.norm(GRID - center, axis=1)
        assert 0 < (~kept).sum()
        assert distance[~kept].max() < distance[kept].min()
        assert distance[~kept].max() <= 0.08 * diagonal(GRID)


def test_removal_never_empties_a_small_cloud():
    points = np.random.default_rng(5).normal(size=(78, 3))
    for seed in range(20):
        assert without_part(np.random.default_rng(seed), points).sum() >= FEWEST_POINTS
        assert undersampled(np.random.default_rng(seed), len(points)).sum() >= FEWEST_POINTS


def test_a_bump_is_smooth_local_and_along_one_direction():
    for seed in range(10):
        bumped, moved = add_bump(np.random.default_rng(seed), GRID)
        shift = bumped - GRID
        assert np.array_equal(bumped[~moved], GRID[~moved])
        # The grid lies in z = 0.5, so the normal is z.
        assert np.abs(shift[:, :2]).max() < 1e-12
        height = np.abs(shift[:, 2])
        assert 0.02 * diagonal(GRID) - 1e-12 <= height.max() <= 0.08 * diagonal(GRID)
        assert (np.sign(shift[moved, 2]) == np.sign(shift[height.argmax(), 2])).all()
        # Half its height within the ellipse, nothing beyond eight standard deviations of at most 5 %.
        away = np.linalg.norm(GRID - GRID[height.argmax()], axis=1)
        assert away[moved].max() <= 8 * 0.05 * diagonal(GRID) + 1e-9


def test_the_ten_types_are_those_of_the_paper():
    assert tuple(TYPES) == PERTURBATIONS
    assert [name for name, recipe in TYPES.items() if recipe.noise == "uniform"] == ["A1", "A5", "A7"]
    assert [name for name, recipe in TYPES.items() if recipe.noise == "gaussian"] == ["A2", "A6", "A8"]
    assert [name for name, recipe in TYPES.items() if recipe.removal == "undersampling"] == ["A3", "A5", "A6"]
    assert [name for name, recipe in TYPES.items() if recipe.removal == "missing_part"] == ["A4", "A7", "A8"]
    assert [name for name, recipe in TYPES.items() if recipe.bump] == ["A9"]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("perturbation", PERTURBATIONS)
def test_the_exact_share_counts_points_on_the_surface(kind, perturbation):
    cloud = sample_cloud(np.random.default_rng(6), kind, perturbation)
    on_surface = np.abs(cloud.primitive.signed_distance(cloud.points)) < 1e-12
    if perturbation in ("A0", "A3", "A4"):
        assert cloud.exact_share == 1.0
    # A bump's foot is so low that some points count as moved and are yet within rounding of the surface.
    assert on_surface.mean() >= cloud.exact_share - 1e-12
    if perturbation != "A9":
        assert on_surface.mean() <= cloud.exact_share + 0.01
