"""Clouds whose noise is known: their noise is as it is said, and the command writes what it counts."""

from pathlib import Path

import numpy as np
import pytest

from benchmark.command import bench
from benchmark.coverage import LAWS, cramer_rao, outcome, scene, waves
from fitting.primitives import KINDS


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
    assert np.ptp(drawn.sigma) > 0.0 if law == "uneven" else np.ptp(drawn.sigma) == 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_the_bound_is_near_what_is_claimed(kind: str) -> None:
    """Under independent noise the linearised standard deviations are those of the Cramer-Rao bound."""
    drawn = scene("independent", kind, 3, KINDS.index(kind))
    bound = np.diag(cramer_rao(drawn))
    assert np.all(bound >= 0.0) and np.all(np.isfinite(bound))
    found = outcome("independent", kind, 3, KINDS.index(kind))
    # squares of errors over their bound are chi^2 with one to three degrees of freedom
    assert found.status == "fitted" and all(square < 16.0 for square in found.relative.values())


def test_the_command_writes_a_table_and_a_picture(tmp_path: Path) -> None:
    assert bench(["coverage", "--n", "1", "--seed", "5", "--out", str(tmp_path)]) == 0
    text = (tmp_path / "uncertainty-coverage.md").read_text(encoding="utf-8")
    assert "primfit bench coverage --n 1 --seed 5" in text
    for law in LAWS[:-1]:
        assert f"| {law} | torus |" in text
    assert "| minimal_sample | 5 | 100 % |" in text
    assert (tmp_path / "images" / "uncertainty-coverage.png").stat().st_size > 1000
