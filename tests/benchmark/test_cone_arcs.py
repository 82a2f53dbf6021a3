"""Short arcs of cones: their angle shows as much as is said, by another least squares."""

import numpy as np
import pytest

from primfit.benchmark.cases import ANGLE_BUCKETS, CASE_SETS, bucket
from primfit.benchmark.cone_arcs import (
    ARC,
    CHI_SQUARED,
    HALF_ANGLE,
    MOST_NOISE,
    POINTS,
    RADIUS_CHANGE,
    arc_cloud,
)
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.synthetic.telling import nearest


def rng(seed: int) -> np.random.Generator:
    return np.random.default_rng([seed, 10])


def feet(cloud) -> np.ndarray:
    """The closest points (N, 3) of a cone, about its apex, axis z."""
    cone = cloud.primitive
    on_cone = cloud.points - cone.signed_distance(cloud.points)[:, None] * cone.gradient(cloud.points)
    across = np.linalg.svd(cone.axis[None])[2][1:]
    return (on_cone - cone.apex) @ np.array([*across, cone.axis]).T


@pytest.mark.parametrize("seed", range(12))
def test_the_angle_shows(seed):
    """Least squares of SciPy from a cylinder along the points' generatrix leaves as much more as is said."""
    cloud, shown = arc_cloud(rng(seed), "cone")
    assert shown > CHI_SQUARED.low and cloud.noise <= MOST_NOISE * cloud.extent
    middle = cloud.points.mean(axis=0) - cloud.primitive.apex
    along = middle / np.linalg.norm(middle)
    radius = float(middle @ along * np.tan(cloud.primitive.half_angle))
    normal = cloud.primitive.gradient(cloud.points.mean(axis=0)[None])[0]
    start = Cylinder(along, cloud.points.mean(axis=0) - radius * normal, radius)
    left = [nearest(surface, cloud.points) ** 2 for surface in (start, cloud.primitive)]
    found = len(cloud.points) * (left[0] - left[1]) / cloud.noise**2
    # SciPy stops where the sum of squares changes by 1e-4 of itself.
    assert found == pytest.approx(shown, abs=0.02 * shown + 2e-4 * len(cloud.points))


def test_arcs_are_as_they_are_said():
    for seed in range(30):
        cloud, _ = arc_cloud(rng(seed), "cone")
        assert HALF_ANGLE.low <= np.degrees(cloud.primitive.half_angle) <= HALF_ANGLE.high
        assert POINTS.low <= len(cloud.points) <= POINTS.high
        x, y, z = feet(cloud).T
        middle = np.arctan2(y.mean(), x.mean())
        azimuth = np.degrees(np.mod(np.arctan2(y, x) - middle + np.pi, 2 * np.pi) - np.pi)
        assert 0.9 * ARC.low <= np.ptp(azimuth) <= ARC.high + 1e-9
        slant = np.sqrt(x**2 + y**2 + z**2)
        assert 0.95 * RADIUS_CHANGE.low <= slant.max() / slant.min() <= 1.05 * RADIUS_CHANGE.high


def test_cylinders_stand_on_the_same_arcs():
    chosen = CASE_SETS["cone-arcs"]
    for index in range(0, 20, 2):
        cone, cylinder = chosen.draw(1, index), chosen.draw(1, index + 1)
        assert (
            (cone.kind, cylinder.kind)
            == ("cone", "cylinder")
            == (
                cone.groups["shape"],
                cylinder.groups["shape"],
            )
        )
        assert cone.noise == cylinder.noise and len(cone.points) == len(cylinder.points)
        assert cone.groups | {"shape": ""} == cylinder.groups | {"shape": ""}
        slant = np.ptp((cone.points - cone.truth.apex) @ cone.truth.axis) / np.cos(cone.truth.half_angle)
        length = np.ptp((cylinder.points - cylinder.truth.point) @ cylinder.truth.axis)
        assert length == pytest.approx(slant, rel=0.25)  # an arc's heights are those of its slant, and noise


def test_the_angle_of_all_levels_is_drawn():
    found = [bucket(ANGLE_BUCKETS, arc_cloud(rng(seed), "cone")[1]) for seed in range(60)]
    assert min(found.count(name) for _, name in ANGLE_BUCKETS) >= 6
