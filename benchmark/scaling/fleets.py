"""Runs of a million to a billion segments on ten to a thousand nodes, as tables."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context

import numpy as np

from . import asked as app
from .model import Course, Fleet, Loads, Loss, Parameters, Storage
from .sets import RECIPE
from .simulation import simulate

SIZES = (10**6, 10**7, 10**8, 10**9)
NODES = (10, 30, 100, 300, 1000)
CORES = 16

EFFICIENT = 0.8
"""Where cores have less to do, more nodes are of little use."""

HOUR = 3600.0
LOSS = Loss(every=500 * HOUR, back=600.0, detected=65.0)
"""Assumed: a node is lost every 500 hours, known to be so after 65 s, and back after ten minutes."""

USUAL = Fleet(1, CORES, uneven=0.05, straggling=0.01, straggle=3.0, loss=LOSS, storage=Storage(0.05, 10e9))
"""Assumed: speeds of nodes differ by 5%, one task of a hundred takes three times as long, an object store."""

WORLDS: dict[str, Fleet] = {
    "nothing goes wrong": Fleet(1, CORES),
    "stragglers: 1 task of 100 takes three times as long, nodes differ by 5%": Fleet(
        1, CORES, uneven=0.05, straggling=0.01
    ),
    "stragglers: 5 of 100 take ten times as long, nodes differ by 20%": Fleet(
        1, CORES, uneven=0.2, straggling=0.05, straggle=10.0
    ),
    "a node is lost every 500 hours": Fleet(1, CORES, loss=LOSS),
    "a node is lost every 10 hours": Fleet(1, CORES, loss=replace(LOSS, every=10 * HOUR)),
    "storage of 10 GB/s, 50 ms": Fleet(1, CORES, storage=Storage(0.05, 10e9)),
    "storage of 1 GB/s, 50 ms": Fleet(1, CORES, storage=Storage(0.05, 1e9)),
    "all of the usual: 1 straggler of 100, losses every 500 hours, 10 GB/s": USUAL,
}

POOL = 200_000
"""Segments whose tasks are those of larger runs, too."""


@dataclass(frozen=True)
class Question:
    """A run on a fleet; `label` stands in its table."""

    segments: int
    fleet: Fleet
    label: str = ""


def pool(seed: int) -> Loads:
    """Tasks of segments with as many points as those of `sets`, as the app cuts them."""
    low, high = np.log([RECIPE.points.low, RECIPE.points.high])
    points = np.exp(np.random.default_rng(seed).uniform(low, high, POOL)).astype(int)
    return Loads.of(app.cut(points.tolist()))


def sizes(largest: int) -> list[Question]:
    """Every size on every number of nodes."""
    return [
        Question(size, replace(USUAL, nodes=nodes)) for size in SIZES if size <= largest for nodes in NODES
    ]


def worlds(segments: int, nodes: int) -> list[Question]:
    """One run where one thing or another goes wrong."""
    return [Question(segments, replace(fleet, nodes=nodes), label) for label, fleet in WORLDS.items()]


def answered(
    questions: Sequence[Question], parameters: Parameters, seed: int, processes: int
) -> Iterator[tuple[Question, Course]]:
    """The simulated runs, in their order."""
    tasks = pool(seed)
    with ProcessPoolExecutor(processes, get_context("spawn")) as workers:
        waiting = [workers.submit(one, question, parameters, tasks, seed) for question in questions]
        for question, course in zip(questions, waiting, strict=True):
            yield question, course.result()


def one(question: Question, parameters: Parameters, tasks: Loads, seed: int) -> Course:
    """A run of tasks drawn from a pool."""
    n_tasks = round(question.segments * len(tasks) / tasks.n_segments)
    loads = tasks.drawn(max(1, n_tasks), np.random.default_rng([seed, question.segments]))
    return simulate(parameters, "ray", question.fleet, loads, seed)


def table(found: Sequence[tuple[Question, Course]]) -> str:
    """Time and efficiency by size and nodes, and what it costs."""
    lines = [
        f"| segments | nodes of {CORES} cores | time | of it plan | efficiency | core-hours | tasks lost |",
        "|---|---|---|---|---|---|---|",
    ]
    for question, course in found:
        lines.append(
            f"| {question.segments:,} | {question.fleet.nodes:,} | {duration(course.wall)} "
            f"| {duration(course.planned)} | {100 * course.efficiency:.0f}% | {course.core_hours:,.0f} "
            f"| {course.lost:,} |"
        )
    return "\n".join(lines)


def world_table(found: Sequence[tuple[Question, Course]]) -> str:
    """The same run under several circumstances."""
    lines = ["| what goes wrong | time | efficiency | core-hours | tasks lost |", "|---|---|---|---|---|"]
    for question, course in found:
        lines.append(
            f"| {question.label} | {duration(course.wall)} | {100 * course.efficiency:.0f}% "
            f"| {course.core_hours:,.0f} | {course.lost:,} |"
        )
    return "\n".join(lines)


def knee(parameters: Parameters, tasks: Loads, found: Sequence[tuple[Question, Course]]) -> str:
    """How many cores one driver keeps busy, and up to which number of nodes that is so in the simulation."""
    team = parameters.teams["ray"]
    task = float(np.mean(tasks.mean(parameters))) * team.slower
    segments = tasks.n_segments / len(tasks)
    saved = f"{1e6 * parameters.saved:.1f} µs for each part in it, every {parameters.saved_every:g} s or more"
    lines = [
        f"A task of {segments:.0f} segments takes {task:.1f} s of a core. The driver takes "
        f"{1e3 * team.per_task:.1f} ms for it: it can hand out {1 / team.per_task:,.0f} tasks a second, "
        f"which is work for {task / team.per_task:,.0f} cores. Before, it plans "
        f"{1 / parameters.planned:,.0f} segments a second, when no core works: a million segments take "
        f"{duration(1e6 * parameters.planned)}. To write the manifest takes {saved}.",
        "",
        f"| segments | most nodes with an efficiency of {100 * EFFICIENT:.0f}% | driver at work there |",
        "|---|---|---|",
    ]
    for size in dict.fromkeys(question.segments for question, _ in found):
        good = [
            (question, course)
            for question, course in found
            if question.segments == size and course.efficiency >= EFFICIENT
        ]
        if not good:
            lines.append(f"| {size:,} | fewer than {NODES[0]} | |")
            continue
        question, course = max(good, key=lambda pair: pair[0].fleet.nodes)
        lines.append(f"| {size:,} | {question.fleet.nodes:,} | {100 * course.driver / course.wall:.0f}% |")
    return "\n".join(lines)


def duration(seconds: float) -> str:
    """Two digits and a unit that suits them."""
    for unit, size in (("d", 86400.0), ("h", HOUR), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"
