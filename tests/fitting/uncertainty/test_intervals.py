"""Intervals hold the truth as often as they say, move with the cloud, and keep to what is fixed or open."""

import numpy as np
import pytest

from primfit.fitting.primitives import names_of, values_of
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import Constraints
from primfit.fitting.uncertainty.intervals import spread
from tests.fitting.clouds import EXAMPLES, noisy
from tests.fitting.uncertainty.known import known

KINDS = tuple(EXAMPLES)


@pytest.mark.parametrize("ratio", [0.0, 0.35, 1.0])
def test_the_radius_of_a_spread_holds_95_of_100_offsets(ratio: float) -> None:
    offsets = np.random.default_rng(0).standard_normal((400_000, 2)) * [2.0, 2.0 * ratio]
    radius = spread(np.diag([4.0, (2.0 * ratio) ** 2]), 1.959964).radius_95
    # a share of 0.95 among 400,000 is known to 0.0004
    assert np.mean(np.linalg.norm(offsets, axis=1) <= radius) == pytest.approx(0.95, abs=0.0015)


@pytest.mark.parametrize("kind", KINDS)
def test_most_intervals_hold_the_truth(kind: str) -> None:
    truth, held = EXAMPLES[kind], []
    names = names_of(kind)
    for seed in range(20):
        found = recognize(noisy(truth, 400, 0.01, seed), Config(kinds=(kind,)))
        assert found.uncertainty and found.primitive
        center = noisy(truth, 400, 0.01, seed).mean(axis=0)
        true = dict(zip(names, values_of(truth.canonical(center)), strict=True))
        held += [each.low <= true[name] <= each.high for name, each in found.uncertainty.intervals.items()]
    # 5% are missed; if the numbers of a cloud went all together, 0.85 would be two standard errors below
    assert np.mean(held) >= 0.85


@pytest.mark.parametrize("kind", KINDS)
def test_uncertainty_moves_and_scales_with_the_cloud(kind: str) -> None:
    points = noisy(EXAMPLES[kind], 500, 0.01)
    here, there = known(points, kind), known(1024.0 * points + [3e4, -1e4, 5e3], kind)
    for name, interval in here.intervals.items():
        factor = 1.0 if name == "half_angle" else 1024.0
        assert there.intervals[name].standard_deviation == pytest.approx(
            factor * interval.standard_deviation, rel=1e-4
        )
    assert there.covariance is not None and here.covariance is not None
    assert np.all(np.linalg.eigvalsh(here.covariance) > -1e-12 * np.trace(here.covariance))


def test_an_axis_that_a_belt_leaves_open_is_a_right_angle_off_at_most() -> None:
    rng, cylinder = np.random.default_rng(1), Cylinder([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 1.0)
    belt = cylinder.surface(rng.uniform(-np.pi, np.pi, 40), rng.uniform(-0.02, 0.02, 40))
    found = known(belt + 0.02 * rng.standard_normal((40, 1)) * cylinder.gradient(belt), "cylinder")
    assert found.direction is not None and found.direction.radius_95 == np.pi / 2
    assert "The axis is not determined." in [each.message for each in found.warnings]


def test_fixed_numbers_are_held_and_help_the_others() -> None:
    points = noisy(EXAMPLES["cylinder"], 400, 0.01)
    free = known(points, "cylinder")
    held = known(points, "cylinder", constraints=Constraints.of({"radius": {"value": 0.8}}))
    assert held.intervals["radius"] == type(held.intervals["radius"])(0.8, 0.8, 0.0, "held")
    for name in ("point.x", "point.z"):
        assert held.intervals[name].standard_deviation <= free.intervals[name].standard_deviation
    axis = known(points, "cylinder", constraints=Constraints.of({"axis": {"direction": [0.2, 0.9, 0.3]}}))
    assert axis.direction is not None and axis.direction.radius_95 == 0.0


def test_an_active_bound_makes_an_interval_one_sided() -> None:
    points = noisy(EXAMPLES["sphere"], 400, 0.01)
    found = known(points, "sphere", constraints=Constraints.of({"radius": {"max": 1.29}}))
    radius = found.intervals["radius"]
    assert radius.method == "bound" and radius.high == 1.29 and radius.low is not None and radius.low < 1.29
