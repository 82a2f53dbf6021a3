"""The simulation of a run, where a formula says what must come out."""

from dataclasses import replace
from math import ceil, inf

import numpy as np
import pytest

pytest.importorskip("simpy", reason="needs simpy, which is in the extra bench")

from primfit.benchmark.scaling.model import Fleet, Loads, Loss, Parameters, Storage, Team
from primfit.benchmark.scaling.simulation import simulate

FREE = Team(start=0.0, end=0.0, per_task=0.0, slower=1.0)
PLAIN = Parameters(
    machine="",
    date="",
    command="",
    runs=[],
    per_segment=0.01,
    per_point=0.0,
    spread=0.0,
    per_part=0.0,
    start=0.0,
    planned=0.0,
    saved=0.0,
    saved_every=5.0,
    saving=1.0,
    ahead=3,
    detected=0.0,
    point_bytes=0.0,
    row_bytes=0.0,
    teams={"local": FREE, "ray": FREE},
)
"""A task of 100 segments takes a second."""


def same(n, segments=100, points=1000):
    return Loads.of([(segments, segments * points, segments * points**2)] * n)


def random(n):
    rng = np.random.default_rng(3)
    return Loads.of([(k, 10 * k, 100 * k) for k in rng.integers(1, 1000, n).tolist()])


def test_one_worker_takes_the_sum():
    loads = random(50)
    teams = {"ray": replace(FREE, start=3.0, end=0.5, slower=1.2)}
    parameters = replace(PLAIN, start=2.0, planned=1e-4, per_point=1e-6, per_part=0.1, teams=teams)
    course = simulate(parameters, "ray", Fleet(1), loads)
    work = 1.2 * (0.01 * loads.n_segments + 1e-6 * loads.points.sum() + 50 * 0.1)
    assert course.work == pytest.approx(work)
    assert course.wall == pytest.approx(2.0 + 1e-4 * loads.n_segments + 3.0 + work + 0.5)


@pytest.mark.parametrize(("tasks", "nodes", "cores"), [(10, 3, 1), (12, 3, 4), (13, 3, 4), (1, 5, 2)])
def test_equal_tasks_take_whole_rounds(tasks, nodes, cores):
    course = simulate(PLAIN, "ray", Fleet(nodes, cores), same(tasks))
    assert course.wall == pytest.approx(ceil(tasks / (nodes * cores)))
    assert course.efficiency == pytest.approx(tasks / (nodes * cores * course.wall))
    assert course.core_hours == pytest.approx(nodes * cores * course.wall / 3600)


def test_workers_share_processors_equally():
    assert simulate(PLAIN, "ray", Fleet(3, shared=2), same(3)).wall == pytest.approx(1.5)
    assert simulate(PLAIN, "ray", Fleet(3, shared=2), same(2)).wall == pytest.approx(1.0)
    # Three until the short one ends after 1.5 s, with 1 s left of each of the others.
    loads = Loads.of([(100, 0, 0), (200, 0, 0), (200, 0, 0)])
    assert simulate(PLAIN, "ray", Fleet(3, shared=2), loads).wall == pytest.approx(2.5)


def test_a_driver_that_is_too_slow_is_what_it_waits_for():
    slow = replace(PLAIN, teams={"ray": replace(FREE, per_task=0.1)})
    course = simulate(slow, "ray", Fleet(100), same(500))
    assert course.wall == pytest.approx(500 * 0.1 + 1.0)
    assert course.driver == pytest.approx(50.0)
    enough = simulate(slow, "ray", Fleet(5), same(500))
    assert enough.wall == pytest.approx(100.0, rel=0.02)


def test_the_manifest_costs_more_the_longer_it_is():
    saving = replace(PLAIN, saved=0.01)
    course = simulate(saving, "ray", Fleet(1), same(100))
    # Written about every five tasks: 0.01 s for each of 5, 10, 15 ... parts.
    assert course.driver == pytest.approx(0.01 * sum(range(5, 100, 5)), rel=0.25)
    seldom = simulate(replace(saving, saving=0.05), "ray", Fleet(1), same(1000))
    assert 0.02 * seldom.wall < seldom.driver < 0.06 * seldom.wall


def test_a_slow_storage_is_what_all_wait_for():
    reading = replace(PLAIN, point_bytes=24.0, row_bytes=100.0)
    fleet = Fleet(50, storage=Storage(bandwidth=1e6))
    bytes_ = 200 * (24 * 100 * 1000 + 100 * 100)
    assert simulate(reading, "ray", fleet, same(200)).wall == pytest.approx(bytes_ / 1e6, rel=0.01)
    late = Fleet(1, storage=Storage(latency=0.25))
    assert simulate(reading, "ray", late, same(10)).wall == pytest.approx(10 * (1.0 + 2 * 0.25))


def test_the_oldest_task_holds_the_others_back():
    loads = Loads.of([(10_000, 0, 0), *[(100, 0, 0)] * 50])
    # Tasks ahead of the straggler: six in all, so that five others are done; 45 are left for two workers.
    course = simulate(PLAIN, "ray", Fleet(2), loads)
    assert course.wall == pytest.approx(100.0 + ceil((50 - 6) / 2))


def test_a_node_that_is_killed_costs_what_it_was_at_and_the_wait():
    whole = simulate(PLAIN, "ray", Fleet(2), same(40))
    killed = Fleet(2, killed=0.5, loss=Loss(detected=4.0))
    course = simulate(PLAIN, "ray", killed, same(40))
    assert whole.wall == pytest.approx(20.0)
    # Twenty tasks by two nodes, nineteen by one, which waits until the lost one is known, and does it last.
    assert course.lost == 1
    assert course.wall == pytest.approx(10.0 + 20.0, abs=1.0 + 4.0)
    # No worker too few where three share two processors: only the lost task is done again.
    shared = [Fleet(3, shared=2, killed=share, loss=Loss(detected=1.0)) for share in (None, 0.5)]
    times = [simulate(PLAIN, "ray", fleet, same(300)).wall for fleet in shared]
    assert times[1] - times[0] == pytest.approx(1.0, abs=1.5)


def test_losses_come_as_often_as_they_are_said_to():
    fleet = Fleet(20, 4, loss=Loss(every=200.0, back=50.0, detected=1.0))
    course = simulate(PLAIN, "ray", fleet, same(40_000))
    up = 200 / (200 + 50)
    assert course.wall == pytest.approx(40_000 / (80 * up), rel=0.1)
    assert course.lost == pytest.approx(4 * 20 * course.wall / 250, rel=0.3)


def test_what_is_lost_is_in_the_end_done():
    fleet = Fleet(3, 2, loss=Loss(every=5.0, back=1.0, detected=0.5))
    course = simulate(PLAIN, "ray", fleet, same(300))
    assert course.lost > 30
    assert np.isfinite(course.wall) and course.wall > 300 / 6
    with pytest.raises(RuntimeError):
        simulate(PLAIN, "ray", Fleet(2, loss=Loss(every=1.0, back=inf)), same(100))


def test_times_of_segments_add_up_to_those_of_tasks():
    parameters = replace(PLAIN, per_point=1e-5, spread=0.8)
    rng = np.random.default_rng(0)
    points = rng.integers(50, 3000, 250)
    loads = Loads.of([(250, int(points.sum()), int((points**2).sum()))] * 20_000)
    drawn = loads.work(parameters, rng)
    means = parameters.per_segment + parameters.per_point * points
    assert drawn.mean() == pytest.approx(means.sum(), rel=1e-3)
    assert drawn.std() == pytest.approx(0.8 * np.sqrt((means**2).sum()), rel=0.02)
    # The sum of times that are gamma distributed, each with its own scale, has nearly the same quantiles.
    summed = rng.gamma(1 / 0.8**2, 0.8**2 * means, (20_000, 250)).sum(axis=1)
    quantiles = (0.01, 0.5, 0.99)
    assert np.quantile(drawn, quantiles) == pytest.approx(np.quantile(summed, quantiles), rel=0.01)


def test_the_same_seed_gives_the_same_course():
    parameters = replace(PLAIN, spread=0.8)
    fleet = Fleet(5, 2, uneven=0.1, straggling=0.1, loss=Loss(every=100.0, back=5.0, detected=1.0))
    first, again, other = (simulate(parameters, "ray", fleet, random(200), seed) for seed in (1, 1, 2))
    assert first == again != other
