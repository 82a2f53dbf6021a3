"""Predictions of runs before they are made, and what became of them."""

from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, Self

import numpy as np
import orjson

from . import asked as app
from .model import Course, Loads, Loss, Parameters
from .parameters import fleet_of
from .records import Asked, RunError, RunRecord, now, written
from .sets import SegmentSet
from .simulation import simulate

SEEDS = 25
"""Simulations of a run, of which the mean is the prediction."""

BAR = 0.10
"""Share by which a prediction may miss the run."""


@dataclass(frozen=True)
class Prediction:
    """Seconds that a run will take: the mean, and where nine of ten simulations lie.

    `parameters` is when those were measured that it follows from.
    """

    asked: Asked
    date: str
    parameters: str
    wall: float
    low: float
    high: float

    def save(self, folder: Path) -> Path:
        return written(folder / "predictions" / f"{self.asked.name}.json", asdict(self))

    @classmethod
    def read(cls, file: Path) -> Self:
        known: dict[str, Any] = orjson.loads(file.read_bytes())
        return cls(asked=Asked(**known.pop("asked")), **known)


def predicted(asked: Asked, folder: Path, parameters: Parameters) -> Prediction:
    """What the simulation says of a run; raises `RunError` where the run is made already."""
    if (folder / "runs" / f"{asked.name}.json").exists():
        raise RunError(f"{asked.name} is made already, so there is nothing to predict")
    if asked.kill == "driver":
        raise RunError("runs whose driver is killed are not predicted")
    loads = Loads.of(app.cut(SegmentSet(folder / "segments", asked.seed, asked.n).lengths()))
    walls = [course.wall for course in courses(asked, loads, parameters)]
    low, high = np.quantile(walls, (0.05, 0.95))
    values = (float(np.mean(walls)), float(low), float(high))
    return Prediction(asked, now(), parameters.date, *(round(value, 1) for value in values))


def courses(asked: Asked, loads: Loads, parameters: Parameters) -> list[Course]:
    """Simulations of a run on this machine."""
    killed = {"killed": asked.at, "loss": Loss(detected=parameters.detected)} if asked.kill == "node" else {}
    fleet = fleet_of(asked.executor, asked.workers, **killed)
    return [simulate(parameters, asked.executor, fleet, loads, seed) for seed in range(SEEDS)]


def predictions(folder: Path) -> list[Prediction]:
    """All that were made, the small runs first."""
    found = [Prediction.read(file) for file in (folder / "predictions").glob("*.json")]
    return sorted(found, key=lambda each: (each.asked.n, each.asked.name))


def verdict(prediction: Prediction, record: RunRecord) -> tuple[bool, str]:
    """Whether a prediction was made before the run and is near enough, and a row that says so."""
    miss = prediction.wall / record.wall - 1.0
    before = datetime.fromisoformat(prediction.date) < datetime.fromisoformat(record.date)
    right = before and prediction.asked == record.asked and abs(miss) <= BAR
    cells = [
        record.asked.name,
        prediction.date if before else f"{prediction.date}, not before the run",
        f"{prediction.wall:.0f} s ({prediction.low:.0f} to {prediction.high:.0f})",
        f"{record.wall:.0f} s",
        f"{100 * miss:+.1f}%" if abs(miss) <= BAR else f"**{100 * miss:+.2f}%**",
    ]
    return right, f"| {' | '.join(cells)} |"


def verdicts(folder: Path, records: list[RunRecord]) -> tuple[bool, str]:
    """Whether all predictions of runs that are made are right, and a table of them; raises `RunError`."""
    made = {record.asked.name: record for record in records}
    found = [verdict(each, made[each.asked.name]) for each in predictions(folder) if each.asked.name in made]
    if not found:
        raise RunError("no run was made of which there is a prediction")
    head = [
        "| run | predicted on | prediction (nine of ten simulations) | run | miss |",
        "|---|---|---|---|---|",
    ]
    lines = [*head, *(line for _, line in found), "", f"The bar is {100 * BAR:.0f}% either way."]
    return all(right for right, _ in found), "\n".join(lines)
