"""Few points decide: the optimum over all points, and the work that it takes."""

import numpy as np
import pytest

from primfit.benchmark.proofs.zones import all_around
from primfit.fitting.cloud.cloud import Cloud
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.zones import descent, exchange
from primfit.fitting.zones.exchange import FEW, ROUNDS, SPREAD, settle
from primfit.fitting.zones.task import MAXIMUM_INSCRIBED, MINIMUM_CIRCUMSCRIBED, MINIMUM_ZONE, Task

TASKS = {"zone": MINIMUM_ZONE, "circumscribed": MINIMUM_CIRCUMSCRIBED, "inscribed": MAXIMUM_INSCRIBED}
STARTS = {"sphere": Sphere([0, 0, 0], 1.0), "cylinder": Cylinder([0, 0, 1], [0, 0, 0], 1.0)}


def prepared(points: Array) -> Cloud:
    return Cloud.prepare(points, None, np.random.default_rng(0))


@pytest.fixture
def sizes(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many points each descent looked at."""
    seen: list[int] = []

    def counted(task: Task, start: Primitive, points: Array, cloud: Cloud) -> descent.End:
        seen.append(len(points))
        return descent.descend(task, start, points, cloud)

    monkeypatch.setattr(exchange, "descend", counted)
    return seen


@pytest.mark.parametrize("task", TASKS.values(), ids=TASKS.keys())
@pytest.mark.parametrize("kind", STARTS)
def test_few_points_lead_to_the_optimum_of_all(kind: str, task: Task, sizes: list[int]) -> None:
    cloud = prepared(all_around(kind, 20_000, 0.01, np.random.default_rng(3)))
    start = cloud.frame.bring(STARTS[kind])
    end, of_all = settle(task, start, cloud), descent.descend(task, start, cloud.points, cloud)
    assert end.is_proven and of_all.is_proven
    assert len(sizes) <= ROUNDS and max(sizes) < len(cloud.points) / 5
    assert task.worst(end.primitive, cloud.points) == pytest.approx(
        task.worst(of_all.primitive, cloud.points), rel=1e-9
    )


def test_the_points_of_one_side_do_not_mislead() -> None:
    """The largest values at the start lie on one side of the sphere, as it is off the center."""
    cloud = prepared(all_around("sphere", 5000, 1e-3, np.random.default_rng(4)))
    start = cloud.frame.bring(Sphere([0.3, 0.2, 0.1], 1.0))
    end = settle(MAXIMUM_INSCRIBED, start, cloud)
    assert end.is_proven
    radius = end.primitive.row()[8]
    np.testing.assert_allclose(radius, np.linalg.norm(cloud.points - end.primitive.row()[3:6], axis=1).min())


def test_points_that_tie_join_in_parts(sizes: list[int]) -> None:
    """On two shells every point is one of the farthest, so all of them are beyond by a little at first."""
    points = all_around("sphere", 100_000, 0.0, np.random.default_rng(5))
    points *= np.where(np.arange(len(points)) % 2, 1.01, 0.99)[:, None]
    cloud = prepared(points)
    end = settle(MINIMUM_ZONE, cloud.frame.bring(Sphere([0.01, 0.0, 0.0], 1.0)), cloud)
    assert end.is_proven
    assert cloud.frame.scale * MINIMUM_ZONE.worst(end.primitive, cloud.points) == pytest.approx(
        0.01, rel=1e-6
    )
    assert len(sizes) <= ROUNDS and max(sizes) < len(points) / 5


def test_what_fails_for_all_points_fails(sizes: list[int]) -> None:
    """Half a sphere holds no inscribed one, however many of its points are looked at."""
    points = all_around("sphere", 5000, 1e-3, np.random.default_rng(6))
    cloud = prepared(points[points[:, 0] > 0.0])
    assert not settle(MAXIMUM_INSCRIBED, cloud.frame.bring(STARTS["sphere"]), cloud).is_proven
    assert 0 < len(sizes) <= ROUNDS


def test_small_clouds_are_looked_at_whole(sizes: list[int]) -> None:
    cloud = prepared(all_around("sphere", FEW + SPREAD, 0.01, np.random.default_rng(7)))
    assert settle(MINIMUM_ZONE, cloud.frame.bring(STARTS["sphere"]), cloud).is_proven
    assert sizes == [FEW + SPREAD]


def test_starts_that_are_one_are_followed_once(sizes: list[int]) -> None:
    """Ten points without noise: all starts, and what lies around them, are the cylinder itself."""
    points = all_around("cylinder", 10, 0.0, np.random.default_rng(0))
    found = recognize(points, Config(kinds=("cylinder",), criterion="maximum_inscribed"))
    assert found.status == "fitted"
    assert 1 <= len(sizes) <= 5  # 45 when each was followed


def test_a_large_zone_looks_at_few_points_many_times(sizes: list[int]) -> None:
    """The zone of 500,000 points on a sphere, for every kind that is tried on them."""
    points = all_around("sphere", 500_000, 0.01, np.random.default_rng(0))
    found = recognize(points, Config(criterion="minimum_zone"))
    assert found.status == "fitted" and isinstance(found.primitive, Sphere)
    assert max(sizes) <= 20 * (FEW + SPREAD)
    distance = np.abs(found.primitive.signed_distance(points))
    assert np.count_nonzero(distance > distance.max() * (1.0 - 1e-9)) >= 5
