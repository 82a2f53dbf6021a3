"""Raw records: one JSON line for each cloud and method, appended as they come, read back by the report.

A folder holds `records.jsonl` and `methods.json`, which says of each method what is the same for all its
records.
"""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from primfit.fitting.primitives import PRIMITIVES, parameters
from primfit.fitting.primitives.primitive import Primitive

from .cases import Case, Level
from .measures import diagonal, fitting_errors, is_right, reference_errors, sampled_errors, truth_errors
from .track import TRACK

Key = tuple[str, int, str, str]

SAMPLED = ("shrec", TRACK)
"""The sets of which the paper's numbers stand beside ours."""

REFERENCED = ("scans-0.3", "scans-2", "outliers", "bias")
"""The sets of which answers are held against least squares on the points of the surface."""

TIMES = ("seconds", "cpu_seconds")
"""The fields that differ from run to run."""


@dataclass(frozen=True)
class Outcome:
    """What became of asking a method.

    Attributes
    ----------
    status : of `benchmark.methods.Answer`; or `error` (an exception), `crash` (its process ended), `timeout`
    primitive : the answer as `fitting.primitives.parameters` has it, or None
    note : the message of the answer or of the failure
    attempts : kinds that were fitted, in order, where the method tells
    alternatives : kinds that an `ambiguous` answer names besides that of `primitive`
    seconds, cpu_seconds : wall clock and processor time of `fit`; None where it did not return
    normals_seconds : processor time of that which went into normals, where the method needs them
    """

    status: str
    primitive: dict[str, Any] | None = None
    note: str = ""
    attempts: tuple[str, ...] = ()
    seconds: float | None = None
    cpu_seconds: float | None = None
    alternatives: tuple[str, ...] = ()
    normals_seconds: float = 0.0


@dataclass(frozen=True)
class Record:
    """One method on one cloud; lengths in the unit of the cloud.

    Attributes
    ----------
    set, seed, case, method : what identifies it
    kind : the true one, or "foreign"
    truth, answer : parameters, or None
    groups : of the case
    points, extent, cloud : number of points, diagonal of those of the surface, start of the SHA-256 of all of
        them
    status, note, attempts, alternatives, seconds, cpu_seconds : as in `Outcome`
    right : `benchmark.measures.is_right`
    errors : of the answer, by measure (`benchmark.measures`); None where a number is not finite
    truth_errors : the measures that need no truth, of the truth itself
    reference_errors : of least squares on the points of the surface; empty where nothing is held against it
    versions : of the method's package and what it runs on
    """

    set: str
    seed: int
    case: str
    method: str
    kind: str
    truth: dict[str, Any] | None
    groups: dict[str, Level]
    points: int
    extent: float
    cloud: str
    status: str
    right: bool
    answer: dict[str, Any] | None
    note: str
    attempts: tuple[str, ...]
    errors: dict[str, float | None]
    truth_errors: dict[str, float | None]
    versions: dict[str, str]
    seconds: float | None = None
    cpu_seconds: float | None = None
    reference_errors: dict[str, float | None] = field(default_factory=dict)
    alternatives: tuple[str, ...] = ()

    @property
    def key(self) -> Key:
        return self.set, self.seed, self.case, self.method

    @property
    def failed(self) -> bool:
        """Whether there was no answer at all."""
        return self.status in ("error", "crash", "timeout")

    def error(self, name: str) -> float:
        """A measure of a right answer; infinite where the answer is wrong, missing or beyond all bounds."""
        value = self.errors.get(name)
        return value if self.right and value is not None else np.inf


def to_primitive(values: dict[str, Any]) -> Primitive:
    """The inverse of `fitting.primitives.parameters`."""
    return PRIMITIVES[values["kind"]](**{name: value for name, value in values.items() if name != "kind"})


@dataclass(frozen=True)
class Scored:
    """A case with what all its records share, computed once."""

    set: str
    seed: int
    case: Case
    center: np.ndarray = field(init=False)
    truth_errors: dict[str, float | None] = field(init=False)
    reference_errors: dict[str, float | None] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", self.case.points.mean(axis=0))
        truth = self.case.truth
        own = _measured(lambda: self._fitting_errors(truth)) if truth else {}
        object.__setattr__(self, "truth_errors", own)
        held = self.set in REFERENCED and truth and self.case.noise
        reference = _measured(self._reference_errors) if held else {}
        object.__setattr__(self, "reference_errors", reference)

    def record(self, method: str, outcome: Outcome, versions: dict[str, str]) -> Record:
        case = self.case
        found = to_primitive(outcome.primitive) if outcome.primitive else None
        return Record(
            set=self.set,
            seed=self.seed,
            case=case.name,
            method=method,
            kind=case.kind,
            truth=parameters(case.truth) if case.truth else None,
            groups=dict(case.groups),
            points=len(case.points),
            extent=diagonal(case.surface_points),
            cloud=hashlib.sha256(np.ascontiguousarray(case.points).tobytes()).hexdigest()[:16],
            status=outcome.status,
            right=is_right(outcome.status, found, case.kind),
            answer=outcome.primitive,
            note=outcome.note,
            attempts=outcome.attempts,
            alternatives=outcome.alternatives,
            errors=_measured(lambda: self._errors(found)) if found else {},
            truth_errors=self.truth_errors,
            reference_errors=self.reference_errors,
            versions=versions,
            seconds=outcome.seconds,
            cpu_seconds=outcome.cpu_seconds,
        )

    @property
    def _points(self) -> np.ndarray:
        return self.case.points - self.center

    @property
    def _on_surface(self) -> np.ndarray:
        return self.case.surface_points - self.center

    def _centred(self, primitive: Primitive) -> Primitive:
        return primitive.transformed(np.eye(3), -self.center, 1.0)

    def _fitting_errors(self, primitive: Primitive) -> dict[str, float]:
        """With a sampled surface, too, where the paper's numbers stand beside."""
        centred = self._centred(primitive)
        errors = fitting_errors(centred, self._points)
        return errors | sampled_errors(centred, self._points) if self.set in SAMPLED else errors

    def _errors(self, found: Primitive) -> dict[str, float]:
        errors = self._fitting_errors(found)
        if self.case.truth:
            errors |= truth_errors(self._centred(found), self._centred(self.case.truth), self._on_surface)
        return errors

    def _reference_errors(self) -> dict[str, float]:
        assert self.case.truth and self.case.noise
        return reference_errors(self._centred(self.case.truth), self._on_surface, self.case.noise)


def _measured(measure: Callable[[], dict[str, float]]) -> dict[str, float | None]:
    """Measures as JSON holds them; wild answers overflow."""
    with np.errstate(all="ignore"):
        return {name: float(value) if np.isfinite(value) else None for name, value in measure().items()}


def _line(record: Record) -> str:
    return json.dumps(asdict(record), allow_nan=False) + "\n"


class RecordsFile:
    """The records of a folder; made where it is missing, continued where a run was cut off."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "records.jsonl"
        self.methods_path = folder / "methods.json"

    def read(self) -> Iterator[Record]:
        """The records; a last line that was cut off is left out."""
        if not self.path.exists():
            return
        with self.path.open() as file:
            for line in file:
                if line.endswith("\n"):
                    values = json.loads(line)
                    kinds = {name: tuple(values.get(name, ())) for name in ("attempts", "alternatives")}
                    yield Record(**values | kinds)

    def append(self, record: Record) -> None:
        with self.path.open("a") as file:
            file.write(_line(record))

    def rewrite(self, records: Iterable[Record]) -> None:
        """Hold these records and nothing else, neither a line that was cut off."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        draft = self.path.with_suffix(".draft")
        draft.write_text("".join(map(_line, records)))
        draft.replace(self.path)

    def methods(self) -> dict[str, dict[str, Any]]:
        """What `benchmark.child` said of each method."""
        if not self.methods_path.exists():
            return {}
        known: dict[str, dict[str, Any]] = json.loads(self.methods_path.read_text())
        return known

    def describe(self, methods: dict[str, dict[str, Any]]) -> None:
        """Add or renew what is known of methods."""
        self.methods_path.write_text(json.dumps(self.methods() | methods, indent=1) + "\n")
