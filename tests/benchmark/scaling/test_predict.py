"""Parameters from runs, predictions, and tables of fleets."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("simpy", reason="needs simpy, which is in the extra bench")
pytest.importorskip("pyarrow", reason="needs pyarrow, which is in the extra bulk")

from primfit.benchmark.scaling import fleets
from primfit.benchmark.scaling.model import Loads, Parameters
from primfit.benchmark.scaling.parameters import fitted, fleet_of, line, through
from primfit.benchmark.scaling.predict import Prediction, courses, predicted, verdict, verdicts
from primfit.benchmark.scaling.records import Asked, RunError
from primfit.benchmark.scaling.sets import PER_FILE, SegmentSet
from primfit.benchmark.scaling.simulation import simulate
from primfit.benchmark.scaling.tables import parameters_table
from tests.benchmark.scaling.made import TASKS, record
from tests.benchmark.scaling.test_simulation import FREE, PLAIN

SMALL, LARGE = Asked(1000, 1, "ray", 3), Asked(5000, 1, "ray", 3)
TEAM = replace(FREE, start=4.0, end=0.5, per_task=0.002, slower=1.3)
PARAMETERS = replace(PLAIN, date="2026-12-01T09:00:00+00:00", start=1.0, teams={"ray": TEAM, "local": FREE})


def test_a_line_through_times_of_segments_has_their_spread():
    rng = np.random.default_rng(2)
    points = rng.integers(50, 3000, 20_000)
    mean = 0.015 + 6e-6 * points
    times = mean * rng.gamma(1 / 0.5**2, 0.5**2, len(points))
    a, b, spread = line(list(zip(points.tolist(), times.tolist(), strict=True)))
    assert (a, b, spread) == pytest.approx((0.015, 6e-6, 0.5), rel=0.05)
    assert through([(1.0, 3.0), (2.0, 5.0)]) == pytest.approx((1.0, 2.0))
    assert through([(1.0, 5.0), (2.0, 3.0)]) == pytest.approx((4.0, 0.0))


def test_a_team_is_found_from_runs_that_are_simulated_with_it():
    runs = []
    for asked, tasks in ((SMALL, TASKS), (LARGE, TASKS * 5)):
        course = simulate(PARAMETERS, "ray", fleet_of("ray", 3), Loads.of(tasks))
        last = course.wall - TEAM.end
        runs.append(record(asked, tasks=tasks, wall=course.wall, planned=1.0, finished=[last]))
    found = fitted(replace(PARAMETERS, teams={"ray": replace(TEAM, start=0, end=0, slower=1)}), "ray", runs)
    assert found.slower == pytest.approx(TEAM.slower, rel=0.01)
    assert (found.start, found.end) == pytest.approx((TEAM.start, TEAM.end), abs=0.1)


def test_parameters_are_kept_and_shown(tmp_path):
    assert Parameters.read(PARAMETERS.save(tmp_path / "parameters.json")) == PARAMETERS
    text = parameters_table(PARAMETERS)
    assert "| a segment, alone on a core | 10.00 ms |" in text and "| ray: driver, a task | 2.00 ms |" in text


def test_a_prediction_comes_before_the_run(tmp_path):
    chosen = SegmentSet(tmp_path / "segments", 1, PER_FILE)
    assert [file.name for file in chosen.draw(1)] == ["00000.parquet"] and not chosen.missing
    asked = Asked(PER_FILE, 1, "ray", 3)
    prediction = predicted(asked, tmp_path, PARAMETERS)
    assert Prediction.read(prediction.save(tmp_path)) == prediction
    expected = 1.0 + TEAM.start + TEAM.end
    assert prediction.low <= prediction.wall <= prediction.high and prediction.wall > expected
    record(asked).save(tmp_path)
    with pytest.raises(RunError, match="made already"):
        predicted(asked, tmp_path, PARAMETERS)
    with pytest.raises(RunError, match="driver"):
        predicted(replace(asked, kill="driver", at=0.3), tmp_path, PARAMETERS)


def test_the_verdict_is_within_a_tenth_and_of_a_run_made_later(tmp_path):
    prediction = Prediction(LARGE, "2026-12-02T09:00:00+00:00", "", 21.0, 20.0, 22.0)
    with pytest.raises(RunError):
        verdicts(tmp_path, [])
    prediction.save(tmp_path)
    right, text = verdicts(tmp_path, [record(LARGE), record(SMALL)])
    assert right and "| ray-3-5000 | 2026-12-02T09:00:00+00:00 | 21 s (20 to 22) | 20 s | +5.0% |" in text
    assert not verdict(replace(prediction, wall=22.1), record(LARGE))[0]
    assert not verdict(replace(prediction, wall=17.9), record(LARGE))[0]
    right, text = verdict(replace(prediction, date="2026-12-02T11:00:00+00:00"), record(LARGE))
    assert not right and "not before the run" in text
    assert not verdict(prediction, record(replace(LARGE, seed=2)))[0]


def test_a_killed_node_costs_little_where_three_share_two_processors():
    loads, uneven = Loads.of(TASKS * 50), replace(PARAMETERS, spread=0.5, detected=1.0)
    whole, killed = (
        np.mean([course.wall for course in courses(asked, loads, uneven)])
        for asked in (LARGE, replace(LARGE, kill="node", at=0.5))
    )
    assert 0.0 < killed - whole < 10.0


def test_fleets_are_simulated_and_shown():
    tasks = fleets.pool(1)
    assert 200 < tasks.n_segments / len(tasks) < 300
    parameters = replace(PARAMETERS, per_segment=0.02, planned=1e-5, saved=1e-6)
    questions = [q for q in fleets.sizes(10**6) if q.fleet.nodes <= 30]
    found = [(question, fleets.one(question, parameters, tasks, 1)) for question in questions]
    again = [fleets.one(question, parameters, tasks, 1) for question in questions]
    assert [course for _, course in found] == again
    few, many = (course for _, course in found)
    assert many.wall < few.wall and many.efficiency < few.efficiency
    text = fleets.table(found)
    assert f"| 1,000,000 | 10 | {fleets.duration(few.wall)} | 11 s |" in text
    assert f"{1 / TEAM.per_task:,.0f} tasks a second" in fleets.knee(parameters, tasks, found)
    assert fleets.duration(90) == "90 s" and fleets.duration(150) == "2.5 min"
    assert fleets.duration(9000) == "2.5 h" and fleets.duration(216_000) == "2.5 d"
