"""Rays against bounded primitives: first hits on the surface, with nothing before them."""

import numpy as np
import pytest

from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.synthetic.patches import Patch

ORIGIN, Z = np.zeros(3), np.array([0.0, 0.0, 1.0])
PATCHES = {
    "plane": Patch(Plane(Z, ORIGIN), (-0.5, 0.5), (-0.2, 0.2)),
    "sphere": Patch(Sphere(ORIGIN, 1.0), (-np.pi, np.pi), (0.0, 2.0)),
    "cylinder": Patch(Cylinder(Z, ORIGIN, 1.0), (-2.0, 2.0), (-1.5, 1.5)),
    "cone": Patch(Cone(ORIGIN, Z, 0.5), (-np.pi, np.pi), (0.2, 1.0)),
    "torus": Patch(Torus(ORIGIN, Z, 2.5, 1.0), (-2.0, 2.0), (-1.0, 4.0)),
}
STATION = np.array([6.0, -5.0, 3.0])


def rays(patch, count=3000):
    """Towards points of the piece, with some that miss it."""
    rng = np.random.default_rng(0)
    targets = patch.sample(rng, count) + 0.1 * rng.standard_normal((count, 3))
    directions = targets - STATION
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


@pytest.mark.parametrize("kind", PATCHES)
def test_samples_belong_to_the_piece_and_points_beyond_its_bounds_do_not(kind):
    patch = PATCHES[kind]
    rng = np.random.default_rng(1)
    assert patch.contains(patch.sample(rng, 500)).all()
    beyond = patch.primitive.surface(rng.uniform(*patch.u, 50), np.full(50, patch.v[1] + 0.05))
    assert not patch.contains(beyond).any()


@pytest.mark.parametrize("solid", [True, False])
@pytest.mark.parametrize("kind", PATCHES)
def test_hits_lie_on_the_piece(kind, solid):
    patch = PATCHES[kind]
    directions = rays(patch)
    distance, hit = patch.first_hits(STATION, directions, solid)
    points = STATION + distance[hit, None] * directions[hit]
    assert 0.1 < hit.mean() < 1.0
    distance = np.abs(patch.primitive.signed_distance(points))
    # Distances of 8, rounded; for rays that graze Newton's steps are shortened.
    assert np.quantile(distance, 0.9) < 1e-14 and distance.max() < 4e-9
    assert patch.contains(points).all()


@pytest.mark.parametrize("kind", ["sphere", "cylinder", "cone", "torus"])
def test_nothing_hides_a_hit_and_nothing_is_missed(kind):
    """Against an oracle that walks each ray and looks for changes of side on the piece."""
    patch = PATCHES[kind]
    directions = rays(patch, 300)
    distance, hit = patch.first_hits(STATION, directions, solid=False)
    walk = np.linspace(3.0, 14.0, 6001)
    points = STATION + walk[None, :, None] * directions[:, None]
    side = np.sign(patch.primitive.signed_distance(points.reshape(-1, 3)).reshape(300, -1))
    crossed = (side[:, 1:] != side[:, :-1]) & patch.contains(points[:, :-1])
    walked = np.where(crossed.any(axis=1), walk[crossed.argmax(axis=1)], np.inf)
    found = np.where(hit, distance, np.inf)
    with np.errstate(invalid="ignore"):
        agree = (np.abs(walked - found) < 0.01) | (walked == found)
    # The walk steps over what a ray only grazes, and over a boundary by a step.
    assert np.mean(agree) > 0.98


def test_a_solid_is_seen_from_outside_only():
    for kind in ("sphere", "cylinder", "cone", "torus"):
        patch = PATCHES[kind]
        directions = rays(patch)
        distance, hit = patch.first_hits(STATION, directions, solid=True)
        points = STATION + distance[hit, None] * directions[hit]
        facing = -np.einsum("ij,ij->i", patch.primitive.gradient(points), directions[hit])
        if kind in ("sphere", "torus"):
            assert facing.min() > -1e-6
        # What a closed object hides is not hit: the shell is seen through its gaps, the solid is not.
        assert hit.sum() <= patch.first_hits(STATION, directions, solid=False)[1].sum()
