"""Clouds whose noise is known: their noise is as it is said, and the command writes what it counts."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from primfit.benchmark.command import bench
from primfit.benchmark.coverage import (
    LAWS,
    bow,
    cramer_rao,
    exponential,
    outcome,
    rays_to,
    scene,
    spacing,
    waves,
    wavy,
)
from primfit.fitting.names import KINDS
from primfit.fitting.primitives.sphere import Sphere


def test_waves_have_unit_variance_and_the_correlation_that_is_said() -> None:
    rng = np.random.default_rng(0)
    pair = np.array([[0.0, 0.0, 0.0], [0.6, 0.0, 0.0]])
    values = np.array([waves(rng, pair) for _ in range(4000)])
    # standard errors of 4,000 pairs are 0.02
    np.testing.assert_allclose(values.T @ values / 4000, np.exp([[0.0, -0.36], [-0.36, 0.0]]), atol=0.08)


@pytest.mark.parametrize("law", LAWS)
def test_points_scatter_by_the_noise_that_is_said(law: str) -> None:
    drawn = scene(law, "sphere", 3, 0)
    scores = drawn.truth.signed_distance(drawn.points) / drawn.sigma
    assert 0.4 < np.std(scores) < 1.8
    assert np.ptp(drawn.sigma) > 0.0 if law in ("uneven", "along the ray") else np.ptp(drawn.sigma) == 0.0


def made(law: Callable[[np.random.Generator, np.ndarray], np.ndarray], clouds: int = 200) -> np.ndarray:
    """Fields (clouds, N) over a square grid of 20 by 20 points, a spacing apart."""
    grid = np.stack(np.meshgrid(np.arange(20.0), np.arange(20.0), [0.0]), axis=-1).reshape(-1, 3)
    rng = np.random.default_rng(1)
    return np.array([law(rng, grid) for _ in range(clouds)])


def test_a_spacing_is_the_side_of_the_square_that_a_point_has() -> None:
    points = np.column_stack([np.random.default_rng(0).random((4000, 2)), np.zeros(4000)])
    assert spacing(points) == pytest.approx(1 / np.sqrt(4000), rel=0.05)


@pytest.mark.parametrize("law", [exponential, wavy])
def test_correlated_fields_have_unit_variance(law: Callable[..., np.ndarray]) -> None:
    # 200 fields of some dozens of independent numbers each
    assert np.var(made(law)) == pytest.approx(1.0, abs=0.06)


def test_an_exponential_range_is_one_to_five_spacings() -> None:
    """The mean of exp(-1 / range) over ranges from 1 to 5 is 0.67, at five steps 0.20 (by Simpson's rule)."""
    fields = made(exponential).reshape(-1, 20, 20)
    reach = np.linspace(1.0, 5.0, 401)
    for steps in (1, 5):
        found = np.mean(fields[:, :, steps:] * fields[:, :, :-steps])
        # the spacing of a grid is within 15% of the side of its cells
        assert found == pytest.approx(np.mean(np.exp(-steps / reach)), abs=0.08)


def test_a_bow_is_half_a_noise_scale_in_the_root_mean_square() -> None:
    rng, truth = np.random.default_rng(2), Sphere([0, 0, 0], 1.0)
    points = truth.surface(rng.uniform(0, 6, 300), rng.uniform(0, 3, 300))
    fields = np.array([bow(rng, truth, points) for _ in range(400)])
    assert np.sqrt(np.mean(fields**2)) == pytest.approx(0.5, abs=4 * 0.5 / np.sqrt(2 * 400))
    assert np.abs(fields.mean(axis=1)).max() < 1e-12


def test_noise_along_the_ray_keeps_points_on_their_rays() -> None:
    """So that a plane's noise along its normal shrinks with the cosine of the incidence."""
    points = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    normals = np.tile([0.0, 0.0, 1.0], (2, 1))
    rays, weights = rays_to(points, np.tile([0.0, 0.0, 4.0], (2, 1)), normals)
    np.testing.assert_allclose(rays, [[0, 0, -1], [0.6, 0, -0.8]])
    # 4 and 5 away, square to it and at an incidence of tangent 3/4
    assert weights[1] / weights[0] == pytest.approx(5 / 4 * np.sqrt(1 + 9 / 64))


@pytest.mark.parametrize("kind", KINDS)
def test_the_bound_is_near_what_is_claimed(kind: str) -> None:
    """Under independent noise the linearised standard deviations are those of the Cramer-Rao bound."""
    drawn = scene("independent", kind, 3, KINDS.index(kind))
    bound = np.diag(cramer_rao(drawn))
    assert np.all(bound >= 0.0) and np.all(np.isfinite(bound))
    found = outcome("independent", kind, 3, KINDS.index(kind))
    # squares of errors over their bound are chi^2 with one to three degrees of freedom
    assert found.status == "fitted" and all(square < 16.0 for square in found.relative.values())


@pytest.mark.slow
def test_the_command_writes_a_table_and_a_picture(tmp_path: Path) -> None:
    assert bench(["coverage", "--n", "1", "--seed", "5", "--out", str(tmp_path)]) == 0
    text = (tmp_path / "uncertainty-coverage.md").read_text(encoding="utf-8")
    assert "primfit bench coverage --n 1 --seed 5" in text
    for law in LAWS:
        if law != "minimal":
            assert f"| {law} | torus |" in text
    assert "| minimal_sample | 5 | 100% |" in text
    assert (tmp_path / "images" / "uncertainty-coverage.png").stat().st_size > 1000


def test_one_law_may_be_asked_for(tmp_path: Path) -> None:
    asked = ["--law", "few", "--law", "along the ray"]
    assert bench(["coverage", "--n", "1", "--seed", "5", "--out", str(tmp_path), *asked]) == 0
    text = (tmp_path / "uncertainty-coverage.md").read_text(encoding="utf-8")
    assert "primfit bench coverage --n 1 --seed 5 --law few --law 'along the ray'" in text
    rows = {line.split(" | ")[0] for line in text.splitlines() if line.count(" | ") > 8}
    assert rows >= {"| few", "| along the ray"} and not rows & {"| bowed", "| independent"}
    assert (tmp_path / "images" / "uncertainty-coverage.png").stat().st_size > 1000


def test_the_noise_that_has_no_intervals_may_be_asked_for_alone(tmp_path: Path) -> None:
    assert bench(["coverage", "--n", "1", "--seed", "5", "--out", str(tmp_path), "--law", "minimal"]) == 0
    assert "| minimal_sample | 5 | 100% |" in (tmp_path / "uncertainty-coverage.md").read_text()
