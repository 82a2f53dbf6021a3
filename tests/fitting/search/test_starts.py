"""Starts: each settles as it would alone, towards most of the points, and the best of them wins."""

import numpy as np
import pytest

from primfit.fitting.cloud.cloud import Cloud
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives import PRIMITIVES
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.search.starts import compete, race
from primfit.fitting.solver.refine import stepped
from primfit.fitting.trial.trial import Trial
from tests.fitting.clouds import EXAMPLES, noisy

examples = pytest.mark.parametrize("primitive", EXAMPLES.values(), ids=EXAMPLES.keys())


def spoilt(primitive: Primitive) -> tuple[Array, Primitive, np.random.Generator]:
    """Points about the origin with noise of 0.01, a fifth of them stray, and the surface that they are of."""
    rng = np.random.default_rng(1)
    points = noisy(primitive, 300, 0.01)
    points[:60] = rng.uniform(points.min(axis=0), points.max(axis=0), (60, 3))
    center = points.mean(axis=0)
    return np.ascontiguousarray(points - center), primitive.transformed(np.eye(3), -center, 1.0), rng


def median_distance(kind: str, row: Array, points: Array) -> float:
    return float(np.median(np.abs(PRIMITIVES[kind].from_row(row).signed_distance(points))))


@examples
def test_a_start_settles_as_it_would_alone_and_nearer_to_most_points(primitive: Primitive) -> None:
    points, truth, rng = spoilt(primitive)
    starts = np.array([stepped(truth, 0.02 * rng.normal(size=primitive.dof)).row() for _ in range(4)])
    trial = Trial(primitive.kind, Cloud.prepare(points, None, rng))
    stages = np.array([[len(points), 12, len(starts)]])
    together, distances = race(trial, starts, points, stages)
    alone = [race(trial, start[None], points, stages)[0][0] for start in starts]
    assert sorted(row.tolist() for row in together) == sorted(row.tolist() for row in alone)
    for row, distance in zip(together, distances, strict=True):
        there = PRIMITIVES[primitive.kind].from_row(row)
        np.testing.assert_allclose(distance, there.signed_distance(points), atol=1e-13)
    for start, row in zip(starts, alone, strict=True):
        after = median_distance(primitive.kind, row, points)
        assert after < min(median_distance(primitive.kind, start, points), 0.02)


@examples
def test_whatever_its_place_the_start_near_the_truth_wins(primitive: Primitive) -> None:
    points, truth, rng = spoilt(primitive)
    far = [stepped(truth, 0.5 * rng.normal(size=primitive.dof)).row() for _ in range(7)]
    near = stepped(truth, 0.01 * rng.normal(size=primitive.dof)).row()
    for place in (0, 3, 7):
        starts = np.array([*far[:place], near, *far[place:]])
        stages = np.array([[100, 3, 4], [300, 6, 1]])
        row, distance = compete(primitive.kind, starts, points, 1e-12, 1e-3, stages)
        found = PRIMITIVES[primitive.kind].from_row(row)
        np.testing.assert_allclose(distance, found.signed_distance(points), atol=1e-13)
        assert median_distance(primitive.kind, row, points) < 0.015


@examples
def test_stages_leave_so_many_starts_the_best_first(primitive: Primitive) -> None:
    points, truth, rng = spoilt(primitive)
    starts = np.array([stepped(truth, 0.3 * rng.normal(size=primitive.dof)).row() for _ in range(9)])
    starts[4, 3:6] = np.nan
    trial = Trial(primitive.kind, Cloud.prepare(points, None, rng))
    rows, distances = race(trial, starts, points, np.array([[50, 2, 6], [120, 4, 3]]))
    assert rows.shape == (3, 9) and distances.shape == (3, 120)
    costs = np.log(np.abs(distances) + 1e-3).sum(axis=1)
    assert (np.diff(costs) >= 0.0).all()
    everything, _ = race(trial, starts, points, np.array([[50, 2, 9]]))
    assert len(everything) == 8, "one cannot be stepped from"
    assert race(trial, starts[:0], points, np.array([[50, 2, 6]]))[0].shape == (0, 9)
