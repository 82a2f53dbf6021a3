"""The tables of docs/scaling.md about runs and parameters."""

from collections.abc import Sequence
from itertools import groupby

from .model import Parameters
from .records import RunRecord

OVERHEAD = 0.15
"""Share that a cluster may take longer than processes of this machine."""


def runs_table(records: Sequence[RunRecord]) -> str:
    """What runs took, and what is to be said of them."""
    lines = [
        "| run | segments, tasks | time | CPU a segment | CPU of driver, of Ray | MiB of driver, of a worker "
        "| bytes a task, there and back | rows, missing, twice |",
        "|---|---|---|---|---|---|---|---|",
        *map(_row, records),
        "",
        *_said(records),
    ]
    return "\n".join(lines)


def _row(record: RunRecord) -> str:
    memory, n_tasks = record.memory, len(record.tasks)
    cells = [
        record.asked.name,
        f"{record.asked.n:,}, {n_tasks}",
        f"{record.wall:.1f} s",
        f"{1e3 * record.worker_cpu / record.asked.n:.1f} ms",
        f"{record.driver_cpu:.1f} s, {record.ray_cpu:.1f} s",
        f"{_own(memory.driver_pss)} ({memory.driver_rss:.0f}), "
        f"{_own(memory.worker_pss)} ({memory.worker_rss:.0f})",
        f"{record.sent // n_tasks:,}, {record.answered // n_tasks:,}",
        f"{record.rows:,}, {record.missing:,}, {record.twice + record.lost:,}",
    ]
    return f"| {' | '.join(cells)} |"


def _own(mebibytes: float) -> str:
    """Own memory; a process that ended before it was asked for has none."""
    return f"{mebibytes:.0f}" if mebibytes else "–"


def _said(records: Sequence[RunRecord]) -> list[str]:
    lines = []
    for (n, _), group in groupby(sorted(records, key=_size), _size):
        same = list(group)
        lines += [_equal(n, same), *_overhead(n, same)]
    return [*lines, *_memory(records)]


def _size(record: RunRecord) -> tuple[int, int]:
    return record.asked.n, record.asked.seed


def _equal(n: int, runs: Sequence[RunRecord]) -> str:
    once = "every segment exactly once" if all(run.once for run in runs) else "NOT every segment once"
    if len(runs) == 1:
        return f"- {n:,} segments: one run, {once}."
    same = "all parts equal byte for byte" if len({run.digest for run in runs}) == 1 else "parts that DIFFER"
    return f"- {n:,} segments: {len(runs)} runs, {same}, {once}."


def _overhead(n: int, runs: Sequence[RunRecord]) -> list[str]:
    """The least time of a cluster against those of processes of this machine, where nothing was killed."""
    walls: dict[str, dict[int, float]] = {"local": {}, "ray": {}}
    for run in runs:
        if run.asked.kill == "none":
            mine = walls[run.asked.executor]
            mine[run.asked.workers] = min(run.wall, mine.get(run.asked.workers, run.wall))
    lines = []
    for nodes, wall in sorted(walls["ray"].items()):
        over = [
            f"{100 * (wall / other - 1.0):+.1f}% against {workers} processes"
            for workers, other in sorted(walls["local"].items())
        ]
        if over:
            lines.append(
                f"- {n:,} segments on {nodes} nodes: {', '.join(over)}; bar: {100 * OVERHEAD:+.0f}%."
            )
    return lines


def _memory(records: Sequence[RunRecord]) -> list[str]:
    """How memory grows from the smallest to the largest run of each executor."""
    lines = []
    for executor in ("local", "ray"):
        asked = [r for r in records if r.asked.executor == executor and r.memory.worker_pss]
        mine = sorted(asked, key=lambda r: r.asked.n)
        if len({r.asked.n for r in mine}) < 2:
            continue
        few, many = mine[0], mine[-1]
        lines.append(
            f"- {executor}, {few.asked.n:,} to {many.asked.n:,} segments: own memory of the driver "
            f"{few.memory.driver_pss:.0f} to {many.memory.driver_pss:.0f} MiB, of a worker "
            f"{few.memory.worker_pss:.0f} to {many.memory.worker_pss:.0f} MiB."
        )
    return lines


def parameters_table(parameters: Parameters) -> str:
    """The parameters with their units."""
    rows = [
        ("a segment, alone on a core", f"{1e3 * parameters.per_segment:.2f} ms"),
        ("a point of it", f"{1e6 * parameters.per_point:.2f} µs"),
        ("spread of the time of a segment", f"{100 * parameters.spread:.0f}% of it"),
        ("to write a part", f"{1e3 * parameters.per_part:.0f} ms"),
        ("start of the driver", f"{parameters.start:.2f} s"),
        ("plan, a segment", f"{1e6 * parameters.planned:.1f} µs"),
        ("manifest, a part, each time", f"{1e6 * parameters.saved:.1f} µs"),
        ("loss of a node that is killed, until it is known", f"{parameters.detected:.2f} s"),
        ("bytes of a row", f"{parameters.row_bytes:,.0f}"),
    ]
    for name, team in parameters.teams.items():
        rows += [
            (f"{name}: from the plan to the first work", f"{team.start:.1f} s"),
            (f"{name}: from the last part to the end", f"{team.end:.2f} s"),
            (f"{name}: driver, a task", f"{1e3 * team.per_task:.2f} ms"),
            (f"{name}: a segment takes of what it takes alone", f"{team.slower:.3f} times"),
        ]
    lines = ["| parameter | value |", "|---|---|", *(f"| {name} | {value} |" for name, value in rows)]
    told = f"{parameters.machine}, {parameters.date[:10]}; from the runs {', '.join(parameters.runs)}."
    return "\n".join([told, "", *lines])
