"""The parameters of the simulation, from steps that are timed alone and from runs that were made."""

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import asked as app
from .cluster import cluster, kill_node
from .model import Fleet, Loads, Parameters, Team
from .records import Executor, RunError, RunRecord, machine, now
from .sets import SegmentSet
from .simulation import simulate

LARGEST = 5000
"""Segments of a run that parameters are taken from, at most."""

EMPTY, SAVED = 1000, 20_000
"""Tasks with nothing to do that the driver is timed with, and parts of a manifest."""

EXECUTORS: tuple[Executor, ...] = ("local", "ray")


def measured(records: Sequence[RunRecord], folder: Path) -> Parameters:
    """Time the steps alone, and take the rest from runs of two sizes with each executor.

    Raises
    ------
    RunError
        There are no runs of two sizes of each executor.
    """
    used = [record for record in records if record.asked.n <= LARGEST and record.asked.kill == "none"]
    for executor in EXECUTORS:
        if len({record.asked.n for record in used if record.asked.executor == executor}) < 2:
            raise RunError(
                f"parameters need runs of two sizes up to {LARGEST} segments with the executor {executor}; "
                "see docs/scaling.md"
            )
    first = folder / "runs" / used[0].asked.name
    segments, parts = app.segment_seconds(first)
    per_segment, per_point, spread = line(segments)
    per_task, detected = _of_drivers(first)
    largest = max(used, key=lambda record: record.asked.n).asked
    listed = SegmentSet(folder / "segments", largest.seed, largest.n).listed()
    planned = app.planning_seconds(listed, largest.n)
    alone = Parameters(
        machine=machine(),
        date=now(),
        command="primfit bench scaling parameters",
        runs=[record.asked.name for record in used],
        per_segment=per_segment,
        per_point=per_point,
        spread=spread,
        per_part=float(np.mean(parts)),
        start=float(np.mean([record.planned - planned * record.asked.n for record in used])),
        planned=planned,
        saved=app.saving_seconds(SAVED),
        saved_every=app.SAVED_EVERY,
        saving=app.SAVING,
        ahead=app.AHEAD,
        detected=detected,
        point_bytes=24.0,
        row_bytes=sum(r.bytes for r in used) / sum(r.rows for r in used),
        teams={name: Team(0.0, 0.0, seconds, 1.0) for name, seconds in per_task.items()},
    )
    teams = {name: fitted(alone, name, [r for r in used if r.asked.executor == name]) for name in EXECUTORS}
    return Parameters(**{**vars(alone), "teams": teams})


def line(times: Sequence[tuple[int, float]]) -> tuple[float, float, float]:
    """Seconds a segment and a point, and the spread of segments of one size, from points and times."""
    points, seconds = np.array(times, float).T
    columns = np.stack([np.ones(len(points)), points], axis=1)
    (a, b), *_ = np.linalg.lstsq(columns, seconds)
    expected = columns @ (a, b)
    return float(a), float(b), float(np.sqrt(np.sum((seconds - expected) ** 2) / np.sum(expected**2)))


def through(pairs: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Height at zero and slope of the line through these points, neither below zero."""
    x, y = np.array(pairs, float).T
    slope = max(0.0, float(np.polyfit(x, y, 1)[0]))
    return max(0.0, float(np.mean(y) - slope * np.mean(x))), slope


def fitted(alone: Parameters, executor: Executor, runs: Sequence[RunRecord]) -> Team:
    """What a team takes, so that simulations of these runs end as the runs did.

    The time from the plan to the last part grows in a line with how much slower segments are, and so does its
    beginning; both follow from simulations with neither.
    """
    base = alone.teams[executor]
    spans = []
    for record in runs:
        bare = Parameters(**{**vars(alone), "start": 0.0, "planned": 0.0, "spread": 0.0})
        course = simulate(
            bare, executor, fleet_of(record.asked.executor, record.asked.workers), loads_of(record)
        )
        spans.append((course.wall, max(record.finished) - record.planned))
    start, slower = through(spans)
    end = float(np.mean([record.wall - max(record.finished) for record in runs]))
    return Team(start, end, base.per_task, slower)


def fleet_of(executor: Executor, workers: int, **more: Any) -> Fleet:
    """This machine, as runs here use it: nodes of one processor share those that there are."""
    processors = os.cpu_count() or 1
    if executor == "local":
        return Fleet(1, workers, shared=processors, **more)
    return Fleet(workers, 1, shared=processors, **more)


def loads_of(record: RunRecord) -> Loads:
    return Loads.of([(each[0], each[1], each[2]) for each in record.tasks])


def _of_drivers(out: Path) -> tuple[dict[Executor, float], float]:
    """Seconds of the driver for a task, by executor, and those until the loss of a node is known."""
    with cluster(2) as nodes:
        ray = app.driver_seconds(out, EMPTY, "ray", 2, nodes.address)
    with cluster(1) as nodes:
        detected = app.detection_seconds(nodes.address, _killing(nodes))
    return {"local": app.driver_seconds(out, EMPTY, "local", 2, None), "ray": ray}, detected


def _killing(nodes: Any) -> Iterator[None]:
    kill_node(nodes)
    yield
