"""The floor: its counts against counts by hand, how they grow, and the machine's ceilings."""

from dataclasses import replace

import pytest

from primfit.benchmark.speed import ceilings
from primfit.benchmark.speed.ceilings import Ceilings, calibration, rate
from primfit.benchmark.speed.floor import DISTANCE, FLOORS, SLOPES, Facts, Work, equations, race, step
from primfit.benchmark.speed.table import STEPS

SCAN = Facts(3000, ("cylinder", "cone"), ("cylinder",), False, False, 2, 5000)
ONE = Ceilings(1e9, 1e9, 1e9, 1e9, 1e9, 1e9, 1e6, 1e6)


def test_a_step_of_a_torus_is_counted_as_by_hand():
    # d = hypot(rho - R, h) - r of a point about the axis, by `around_axis` and `torus_loop` without slopes
    assert DISTANCE["torus"] == Work(flops=(3 + 5 + 6 + 5) + 4 + 1, roots=2)
    # lower triangle with the diagonal (28) and the gradient (7) in fused sums, 7 products with the weight
    assert equations(7) == Work(flops=2 * 28 + 2 * 7 + 7)
    assert step("torus") == DISTANCE["torus"] * 2 + SLOPES["torus"] + equations(7) + Work(12, 2)


def test_work_is_added_and_takes_the_longer_of_arithmetic_and_memory():
    work = Work(flops=2.0, hashed=1.0) + Work(flops=1.0, moved=2.0, calls=3.0) * 2.0
    assert work == Work(flops=4.0, hashed=1.0, moved=4.0, calls=6.0)
    assert Work(flops=4e9, roots=1e9, logs=1e9, compares=1e9, hashed=1e9).seconds(ONE) == 8.0
    assert Work(flops=1e9, moved=3e9, calls=1e6).seconds(ONE) == 4.0


def test_every_step_has_a_floor():
    assert list(FLOORS) == list(STEPS)
    for name, floor in FLOORS.items():
        assert floor(SCAN).seconds(ONE) > 0.0, name


@pytest.mark.parametrize("name", FLOORS)
def test_floors_grow_with_the_points_and_no_faster_than_a_sort(name):
    few, many = (FLOORS[name](replace(SCAN, points=count)).seconds(ONE) for count in (2000, 16_000))
    assert few <= many <= 8.0 * 1.5 * few


def test_exact_points_need_less_and_more_kinds_more():
    for name in ("starts", "anneal", "polish", "evidence", "uncertainty"):
        exact = FLOORS[name](replace(SCAN, exact=True)).seconds(ONE)
        assert exact < FLOORS[name](SCAN).seconds(ONE), name
    for name in ("starts", "anneal", "polish", "evidence", "verdict"):
        one = FLOORS[name](replace(SCAN, tried=("cylinder",))).seconds(ONE)
        assert one < FLOORS[name](SCAN).seconds(ONE), name
    assert FLOORS["rivals"](replace(SCAN, rivals=0)) == FLOORS["starts"](replace(SCAN, spared=True)) == Work()
    assert FLOORS["extents"](replace(SCAN, answered=())) == Work()


def test_a_race_is_counted_as_by_hand():
    """25 planes on 64 points, of which 12 go on with all 100 that there are; guesses are solved on those."""
    found = race("plane", 25, 100)
    one, medians = step("plane"), 25 * 4 * 64 + 12 * 6 * 100
    assert found.roots == one.roots * medians
    assert found.flops == one.flops * medians + medians + 160.0 * 100 * 25
    assert found.compares == 3.0 * medians


def test_the_ceilings_are_those_of_a_machine():
    assert all(value > 1e3 for value in vars(Ceilings.measured()).values())
    assert calibration() > 0.0


def test_the_fastest_repeat_counts(monkeypatch):
    """Each work takes a microsecond, in the first repeats two."""
    done = []
    now = [0]

    def work():
        done.append(1)
        now[0] += 2000 if len(done) <= 20 else 1000

    monkeypatch.setattr(ceilings.time, "process_time_ns", lambda: now[0])
    assert rate(work, 10) == 1e6 and len(done) == 10 * ceilings.REPEATS
