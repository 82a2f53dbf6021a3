"""Batches: reproducible in any order, balanced, of the benchmark's sizes."""

from collections import Counter

import numpy as np
import pytest

from primfit.fitting.names import KINDS
from primfit.synthetic import PERTURBATIONS, BenchmarkRecipe, batch, cloud


def same(a, b):
    return np.array_equal(a.points, b.points) and (a.kind, a.perturbation) == (b.kind, b.perturbation)


def test_a_cloud_depends_on_seed_and_index_only():
    recipe = BenchmarkRecipe(seed=5)
    forward = list(batch(5, 12))
    backward = [cloud(recipe, index) for index in reversed(range(12))][::-1]
    assert all(same(a, b) for a, b in zip(forward, backward, strict=True))
    assert all(same(a, b) for a, b in zip(forward[7:], batch(5, 5, start=7), strict=True))
    assert not any(same(a, b) for a, b in zip(forward, batch(6, 12), strict=True))


def test_global_random_state_plays_no_part():
    first = next(batch(1, 1))
    np.random.seed(3)  # noqa: NPY002
    assert same(first, next(batch(1, 1)))


def test_kinds_take_turns_and_perturbations_have_their_frequencies():
    clouds = list(batch(7, 1000))
    assert Counter(c.kind for c in clouds) == dict.fromkeys(KINDS, 200)
    counts = Counter(c.perturbation for c in clouds)
    # 5/46 and 1/46 of 1000, within four standard deviations.
    assert all(abs(counts[name] - 108.7) < 40 for name in PERTURBATIONS[:9])
    assert abs(counts["A9"] - 21.7) < 19


def test_sizes_are_those_of_the_benchmark():
    """Quantiles of the training clouds, to a fifth (those of 400 vary so); the extremes are theirs."""
    quantiles = {
        "plane": (545, 2412, 6400),
        "cylinder": (486, 2086, 6357),
        "sphere": (590, 2712, 6400),
        "cone": (526, 2708, 6399),
        "torus": (1001, 4244, 8100),
    }
    full_share = {"plane": 0.053, "cylinder": 0.042, "sphere": 0.077, "cone": 0.047, "torus": 0.146}
    for kind, expected in quantiles.items():
        sizes = np.array([len(c.points) for c in batch(8, 400, kinds=(kind,))])
        full = 8100 if kind == "torus" else 6400
        np.testing.assert_allclose(np.quantile(sizes, [0.05, 0.5, 0.95]), expected, rtol=0.2)
        assert 77 <= sizes.min() and sizes.max() <= full
        # Four standard deviations of such shares among 400.
        assert abs(np.mean(sizes == full) - full_share[kind]) < 0.07


@pytest.mark.parametrize("kind", ["cone", "torus"])
def test_bumps_are_on_whole_grids_that_are_turned(kind):
    for c in batch(13, 20, kinds=(kind,), perturbations=("A9",)):
        assert len(c.points) == (8100 if kind == "torus" else 6400)
        assert abs(c.primitive.axis[2]) < 1.0


def test_exact_shares_reach_from_a_fifth_to_all():
    shares = [c.exact_share for c in batch(9, 500, perturbations=PERTURBATIONS[:9])]
    # Undersampling a cloud of which a fifth is exact moves that share by a few points.
    assert 0.15 < min(shares) < 0.3
    assert max(shares) == 1.0


def test_clouds_are_finite_float64():
    for c in batch(10, 50):
        assert c.points.dtype == np.float64 and c.points.ndim == 2 and c.points.shape[1] == 3
        assert np.isfinite(c.points).all()


def test_restricted_recipes_draw_only_what_they_name():
    clouds = list(batch(11, 20, kinds=("cone", "torus"), perturbations=("A2", "A9")))
    assert {c.kind for c in clouds} == {"cone", "torus"}
    assert {c.perturbation for c in clouds} <= {"A2", "A9"}


@pytest.mark.parametrize(
    "options", [{"kinds": ("cube",)}, {"kinds": ()}, {"perturbations": ("A10",)}, {"seed": -1}]
)
def test_recipes_refuse_what_they_do_not_know(options):
    with pytest.raises(ValueError, match="must"):
        BenchmarkRecipe(**{"seed": 0, **options})
