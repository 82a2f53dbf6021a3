"""Steps of coordinates are noticed, and what is done about them is needed."""

import numpy as np
import pytest

from primfit.fitting.errors import InvalidPointCloudError
from primfit.fitting.geometry.vectors import bounds
from primfit.fitting.noise import rounding
from primfit.fitting.noise.rounding import rounding_of
from primfit.fitting.recognize import recognize
from tests.fitting.clouds import EXAMPLES, rotation, sample
from tests.fitting.noise.spheres import radius_error

Patch = pytest.MonkeyPatch


@pytest.mark.parametrize(
    ("points", "expected"),
    [
        (np.round(sample(EXAMPLES["sphere"], 300), 3), 1e-3),
        (np.round(1e4 * sample(EXAMPLES["sphere"], 300)), 1.0),
        (np.round(sample(EXAMPLES["sphere"], 300), 3) + 5e5, 1e-3),
        (np.round(9.0 * sample(EXAMPLES["sphere"], 300) / 0.005) * 0.005, 0.005),
        (np.round(sample(EXAMPLES["sphere"], 300) / 0.00025) * 0.00025 + 0.0001, 0.00025),
        (4.0 * np.round(sample(EXAMPLES["sphere"], 300), 3), 0.004),
        (np.round(400.0 * sample(EXAMPLES["sphere"], 30_000) / 0.25) * 0.25, 0.25),
    ],
    ids=["decimals", "integers", "georeferenced", "five of a thousand", "offset", "scaled", "quarters"],
)
def test_quantized_coordinates_are_noticed(points: np.ndarray, expected: float) -> None:
    assert rounding_of(points).size == expected
    assert rounding_of(points).step == expected


def test_a_grid_has_the_step_of_all_its_points() -> None:
    grid = np.stack(np.meshgrid(np.arange(512.0), np.arange(512.0), [0.0]), axis=-1).reshape(-1, 3)
    assert rounding_of(grid).step == 1.0
    assert rounding_of(grid).size < 1e-2, "that is its lattice"


def test_the_resolution_of_full_and_single_precision() -> None:
    points = sample(EXAMPLES["sphere"], 300)
    assert rounding_of(points).size < 1e-13
    assert 1e-8 < rounding_of(points.astype(np.float32).astype(np.float64)).size < 1e-5
    lattice = np.stack(np.meshgrid(*[np.arange(6.0)] * 3), axis=-1).reshape(-1, 3)
    assert rounding_of(lattice).size < 1e-4


def test_without_a_margin_of_rounding_a_cloud_that_was_turned_often_is_not_exact(monkeypatch: Patch) -> None:
    points = sample(EXAMPLES["torus"], 600)
    for seed in range(100):
        points = points @ rotation(seed).T

    def exact_share() -> float:
        answer = recognize(points)
        assert answer.noise is not None
        return answer.noise.exact_share

    assert exact_share() == 1.0
    monkeypatch.setattr(rounding, "ULPS", 1)
    assert exact_share() < 0.9


def test_a_coarse_step_taken_for_a_rounding_makes_a_grid_collinear(monkeypatch: Patch) -> None:
    grid = np.stack(np.meshgrid(np.arange(6.0), np.arange(6.0), [0.0]), axis=-1).reshape(-1, 3)
    assert recognize(grid).primitive is not None
    monkeypatch.setattr(rounding, "COARSEST_STEPS", 1)
    with pytest.raises(InvalidPointCloudError, match="collinear"):
        recognize(grid)


def test_a_fine_step_taken_for_noise_hides_the_exact_points(monkeypatch: Patch) -> None:
    points = sample(EXAMPLES["sphere"], 1000)
    points[:800] += np.random.default_rng(2).uniform(-0.1, 0.1, (800, 3))
    points = np.round(points, 4)
    assert radius_error(points) < 1e-5
    monkeypatch.setattr(rounding, "COARSEST_STEPS", np.inf)
    assert radius_error(points) > 1e-3


FAR = np.array([532_415.3, 5_463_024.7, 316.2])
"""Where the step of float32 numbers is 0.5."""


def in_float32(points: np.ndarray, size: float) -> np.ndarray:
    """A cloud of a size of about 2, made this much larger, and stored far from the origin as float32."""
    return (size / 2.0 * points + FAR).astype(np.float32).astype(np.float64)


def test_a_cloud_of_few_float32_steps_is_refused_and_the_remedy_told() -> None:
    points = sample(EXAMPLES["sphere"], 500) / EXAMPLES["sphere"].radius
    said = r"not 30 steps of its coordinates; float32 .* steps of 0\.5: store float64, or subtract an offset"
    for size in (2.0, 10.0):
        with pytest.raises(InvalidPointCloudError, match=said):
            recognize(in_float32(points, size))
        assert recognize(size / 2.0 * points + FAR).status == "fitted"
    assert recognize(in_float32(points, 20.0)).primitive is not None


def test_points_that_float32_makes_one_or_a_line_are_told_so() -> None:
    points = sample(EXAMPLES["sphere"], 500) / EXAMPLES["sphere"].radius
    with pytest.raises(InvalidPointCloudError, match=r"the same one; float32 .* steps of 0\.5"):
        recognize(in_float32(1e-6 * points, 2.0))
    with pytest.raises(InvalidPointCloudError, match=r"collinear .* determined; float32 .* steps of 0\.5"):
        recognize(in_float32([0.1, 0.1, 100.0] * points, 1.0))


def test_float32_steps_are_coarse_only_far_from_the_origin_and_where_numbers_along_an_axis_are_such() -> None:
    points = sample(EXAMPLES["sphere"], 500) / EXAMPLES["sphere"].radius
    near = points.astype(np.float32).astype(np.float64)
    assert rounding.float32_step(near, bounds(near)) is None
    for size, step in ((20.0, 0.5), (400.0, 0.5), (600.0, None)):
        far = in_float32(points, size)
        assert rounding.float32_step(far, bounds(far)) == step
        far[17, 2] += 1e-9
        assert rounding.float32_step(far, bounds(far)) == step
        far[17, :2] += 1e-9
        assert rounding.float32_step(far, bounds(far)) is None


def test_float32_coordinates_that_were_printed_since_are_told_by_their_steps() -> None:
    """With two decimals the height above 316 is no float32 number, and the steps of 0.5 remain."""
    points = sample(EXAMPLES["sphere"], 500) / EXAMPLES["sphere"].radius
    printed = np.round(in_float32(points, 10.0), 2)
    with pytest.raises(
        InvalidPointCloudError, match=r"not 30 steps of its coordinates; float32 .* steps of 0\.5"
    ):
        recognize(printed)
    wall = (5.0 * points + FAR) * [1.0, 0.0, 1.0] + [0.0, 5_463_024.5, 0.0]
    assert recognize(np.round(wall, 4)).primitive.kind == "plane"  # type: ignore[union-attr]


def test_coordinates_too_large_for_float32_are_none() -> None:
    huge = sample(EXAMPLES["sphere"], 50) * 1e30 + 1e45
    assert rounding.float32_step(huge, bounds(huge)) is None


def test_a_grid_of_whole_numbers_was_not_made_by_float32() -> None:
    x, y = np.meshgrid(np.arange(10.0), np.arange(10.0))
    grid = np.column_stack([x.ravel(), y.ravel(), 0.25 * x.ravel()]) + np.floor(FAR)
    assert rounding.float32_step(grid, bounds(grid)) is None
    assert recognize(grid).status == "fitted"
    halves = grid - [0.0, 0.5, 0.0] * (x.reshape(-1, 1) == 3.0)
    assert rounding.float32_step(halves, bounds(halves)) == 0.5
