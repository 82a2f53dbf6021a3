"""Ragged borders, edge fringes, comet tails: where they are, how far, how many."""

import numpy as np
import pytest

from primfit.fitting.primitives.plane import Plane
from primfit.synthetic.borders import FRINGE_SIZE, MOST_MIXED, TAIL_REACH, comet_tail, edge_fringe, ragged
from primfit.synthetic.effects import Seen

NOISE = 0.002


@pytest.fixture
def wall():
    """A square of 1 m on a grid, seen from 2 m above its middle."""
    x, y = (a.ravel() for a in np.meshgrid(*2 * [np.linspace(-0.5, 0.5, 60)], indexing="ij"))
    points = np.column_stack([x, y, np.zeros(len(x))])
    rays = points - [0.0, 0.0, 2.0]
    distance = np.linalg.norm(rays, axis=1)
    rays /= distance[:, None]
    ones, none = np.ones(len(x)), np.zeros(len(x), dtype=np.intp)
    edge = np.maximum(np.abs(x), np.abs(y)) > 0.49
    normals = np.tile([0.0, 0.0, 1.0], (len(x), 1))
    return Seen(
        points,
        normals,
        rays,
        distance,
        -rays[:, 2],
        -rays[:, 2],
        points[:, :2] / 2,
        none,
        y,
        none,
        edge,
        ones,
    )


def along(seen, moved):
    shift = moved - seen.points
    assert np.abs(np.cross(shift, seen.rays)).max() < 1e-12
    return np.einsum("ij,ij->i", shift, seen.rays)


def test_comet_tails_go_back_from_the_edge_and_nowhere_else(wall):
    for seed in range(10):
        moved, mixed = comet_tail(np.random.default_rng(seed), wall, wall.points)
        back = along(wall, moved)
        assert mixed.any() and not mixed[~wall.on_edge].any() and mixed.mean() <= MOST_MIXED
        assert not back[~mixed].any()
        assert 0.0 <= back.min() and back.max() <= TAIL_REACH.high * wall.extent


def test_fringes_lean_to_one_side_by_some_noises(wall):
    sides = set()
    for seed in range(20):
        moved, mixed = edge_fringe(np.random.default_rng(seed), wall, wall.points, NOISE)
        off = along(wall, moved)
        assert mixed.any() and not mixed[~wall.on_edge].any() and mixed.mean() <= MOST_MIXED
        assert not off[~mixed].any() and np.abs(off).max() <= FRINGE_SIZE.high * NOISE
        assert len({*np.sign(off[mixed])}) == 1
        sides |= {*np.sign(off[mixed])}
    assert sides == {-1.0, 1.0}


@pytest.mark.parametrize("keeps", [0.5, 0.9])
def test_a_ragged_border_keeps_its_share_and_wanders(wall, keeps):
    kept = ragged(np.random.default_rng(1), wall.points, keeps)
    assert kept.mean() == pytest.approx(keeps, abs=0.01)
    # No straight line separates what is kept from what is not: the best one leaves points on the wrong side.
    design = np.column_stack([wall.points[:, :2], np.ones(len(kept))])
    line = design @ np.linalg.lstsq(design, np.where(kept, 1.0, -1.0), rcond=None)[0]
    wrong = np.mean((line >= np.quantile(line, 1.0 - keeps)) != kept)
    assert 0.002 < wrong < 0.2
    assert np.abs(Plane([0, 0, 1], [0, 0, 0]).signed_distance(wall.points[kept])).max() == 0.0
