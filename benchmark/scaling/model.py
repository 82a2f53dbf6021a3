"""What a run is made of: the parameters, the loads, and where it runs."""

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np
import orjson

from .records import Executor, written

FILE = Path(__file__).with_name("parameters.json")

Floats = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class Team:
    """What differs between processes of this machine and a cluster.

    Attributes
    ----------
    start : seconds from the plan to the first work of warm workers
    end : seconds from the last part to the end of the command
    per_task : seconds of the driver for each task
    slower : times that a segment takes in a run, of what it takes alone on this machine
    """

    start: float
    end: float
    per_task: float
    slower: float


@dataclass(frozen=True)
class Parameters:
    """What a run costs, in seconds.

    Attributes
    ----------
    machine, date, command : where, when and how they were measured
    runs : names of the runs that they follow from
    per_segment, per_point : of a core, alone, from the stored points to the row
    spread : standard deviation of the time of a segment, as a share of its mean
    per_part : of the worker, to write a part
    start, planned : of the driver, before the plan, and for each segment of the plan
    saved : of the driver, each time that it writes the manifest, for each part in it
    saved_every, saving : from one writing of the manifest to the next, at least; and the share of the time
        that the driver writes it in, at most
    ahead : tasks handed out or kept back for their turn, for each worker, at most
    detected : from the loss of a machine to the error that tells of it
    point_bytes, row_bytes : read for a point, and written for a segment
    """

    machine: str
    date: str
    command: str
    runs: list[str]
    per_segment: float
    per_point: float
    spread: float
    per_part: float
    start: float
    planned: float
    saved: float
    saved_every: float
    saving: float
    ahead: int
    detected: float
    point_bytes: float
    row_bytes: float
    teams: dict[Executor, Team]

    def save(self, file: Path = FILE) -> Path:
        return written(file, asdict(self))

    @classmethod
    def read(cls, file: Path = FILE) -> Self:
        known = orjson.loads(file.read_bytes())
        teams = {name: Team(**team) for name, team in known.pop("teams").items()}
        return cls(teams=teams, **known)


@dataclass(frozen=True, eq=False)
class Loads:
    """Tasks by what they hold: arrays of the numbers of segments, of points, and of the squares of points."""

    segments: Floats
    points: Floats
    squares: Floats

    def __len__(self) -> int:
        return len(self.segments)

    @property
    def n_segments(self) -> float:
        return float(self.segments.sum())

    @classmethod
    def of(cls, tasks: list[tuple[int, int, int]]) -> Self:
        return cls(*np.array(tasks, float).reshape(-1, 3).T)

    def drawn(self, n: int, rng: np.random.Generator) -> "Loads":
        """So many tasks, each one of these."""
        chosen = rng.integers(len(self), size=n)
        return Loads(self.segments[chosen], self.points[chosen], self.squares[chosen])

    def mean(self, parameters: Parameters) -> Floats:
        """The expected work of each task on one core, alone [s]."""
        segments = parameters.per_segment * self.segments + parameters.per_point * self.points
        return segments + parameters.per_part

    def work(self, parameters: Parameters, rng: np.random.Generator) -> Floats:
        """The work of each task [s].

        A segment takes a + b points on the average, with a standard deviation of the same share everywhere.
        The sum over a task has the mean and the variance of a sum of independent times, and is drawn from the
        gamma distribution that has them: of times that are gamma distributed with one scale the sum is
        exactly that, of others nearly, for a task has a hundred segments or more; it is never negative.
        """
        a, b = parameters.per_segment, parameters.per_point
        mean = self.mean(parameters) - parameters.per_part
        squares = a * a * self.segments + 2 * a * b * self.points + b * b * self.squares
        variance = parameters.spread**2 * squares
        if not parameters.spread:
            return mean + parameters.per_part
        return rng.gamma(mean**2 / variance, variance / mean) + parameters.per_part


@dataclass(frozen=True)
class Storage:
    """Where segments are read and parts are written: seconds before each answer, and bytes a second for all
    together."""

    latency: float = 0.0
    bandwidth: float = float("inf")


@dataclass(frozen=True)
class Loss:
    """Nodes are lost: each after so many seconds on the average, and is back after so many; `detected` is how
    long it takes until the driver knows."""

    every: float = float("inf")
    back: float = float("inf")
    detected: float = 0.0


@dataclass(frozen=True)
class Fleet:
    """Where a run is made.

    Attributes
    ----------
    shared : processors that all workers share; None where each has its own
    uneven : standard deviation of the speed of nodes, as a share
    straggling : share of the tasks that take `straggle` times as long as they should
    killed : the share of finished tasks at which a node is lost for good, or None
    """

    nodes: int
    cores: int = 1
    shared: int | None = None
    uneven: float = 0.0
    straggling: float = 0.0
    straggle: float = 3.0
    killed: float | None = None
    loss: Loss = field(default_factory=Loss)
    storage: Storage = field(default_factory=Storage)

    @property
    def workers(self) -> int:
        return self.nodes * self.cores


@dataclass(frozen=True)
class Course:
    """How a run went.

    Attributes
    ----------
    wall : seconds from the start to the end
    work : seconds of cores that all tasks take once
    planned : seconds until the plan was made
    driver : seconds that the driver was at work, the plan included
    lost : tasks that were lost with their nodes, as often as they were
    """

    wall: float
    work: float
    planned: float
    driver: float
    lost: int
    workers: int

    @property
    def efficiency(self) -> float:
        """Work as a share of what all cores could have done meanwhile."""
        return self.work / (self.wall * self.workers)

    @property
    def core_hours(self) -> float:
        """That are paid for: all cores from the start to the end."""
        return self.wall * self.workers / 3600
