"""What is known of a job."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

ACCEPTED, RUNNING, SUCCESSFUL, FAILED, DISMISSED = "accepted", "running", "successful", "failed", "dismissed"
ENDED = (SUCCESSFUL, FAILED, DISMISSED)


@dataclass(frozen=True)
class Part:
    """Lines of the results that one attempt at the job has told: they stand in files of its own."""

    attempt: int
    lines: int
    bytes: int


@dataclass(frozen=True)
class NewJob:
    """A job as a client hands it in.

    `key` is its Idempotency-Key, `fingerprint` what has to be the same where the key is, `request` what it
    takes to open the body again, `bytes` the length of the body.
    """

    id: str
    owner: str
    key: str | None
    fingerprint: str
    request: Mapping[str, Any]
    n_files: int
    bytes: int


@dataclass(frozen=True)
class Progress:
    """How far a job is: the parts of its results, how many lines they hold, and which share of all, in %."""

    parts: tuple[Part, ...] = ()
    lines: int = 0
    percent: int = 0


@dataclass(frozen=True)
class Job:
    """A job as its record has it; times are seconds since 1970.

    `attempt` counts how often it was begun: the attempt of this number, and no earlier one, may change the
    record. `beat` counts the signs of life of the service that works on it.
    """

    seq: int
    id: str
    owner: str
    fingerprint: str
    request: Mapping[str, Any]
    n_files: int
    status: str
    attempt: int
    beat: int
    progress: Progress
    bytes: int
    created: float
    updated: float
    started: float | None
    finished: float | None
    expires: float | None
    summary: Mapping[str, int] | None
    problem: Mapping[str, Any] | None

    @property
    def ended(self) -> bool:
        return self.status in ENDED
