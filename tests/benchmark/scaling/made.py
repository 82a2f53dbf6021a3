"""A record of a run that was never made."""

from primfit.benchmark.scaling.records import Asked, Memory, RunRecord

TASKS = [(240, 170_000, 240_000_000)] * 4


def record(asked: Asked, **changed) -> RunRecord:
    memory = Memory(130.0, 90.0, 140.0, 80.0, [(0.0, 80.0, 70.0)])
    known = {
        "machine": "one, 2 processors",
        "date": "2026-12-02T10:00:00+00:00",
        "wall": 20.0,
        "driver_cpu": 1.5,
        "worker_cpu": 19.0,
        "ray_cpu": 0.0,
        "memory": memory,
        "tasks": TASKS,
        "planned": 1.0,
        "finished": [9.0, 9.5, 18.0, 19.0],
        "killed": None,
        "lost": 0,
        "twice": 0,
        "sent": 160_000,
        "answered": 640,
        "loopback": 0,
        "points": 680_000,
        "bytes": 1_800_000,
        "rows": asked.n,
        "unique": asked.n,
        "expected": asked.n,
        "missing": 0,
        "statuses": {"fitted": asked.n},
        "digest": "ab",
    }
    return RunRecord(asked=asked, **{**known, **changed})
