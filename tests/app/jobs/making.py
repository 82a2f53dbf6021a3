"""New jobs for tests."""

import itertools
from typing import Any

from primfit.app.jobs.record import NewJob

_numbers = itertools.count(1)
MANY = 10**9


def new(owner: str = "alice", key: str | None = None, fingerprint: str = "f", n_bytes: int = 10) -> NewJob:
    request: dict[str, Any] = {"request_id": "r", "query": [["seed", "3"]]}
    return NewJob(f"job-{next(_numbers)}", owner, key, fingerprint, request, 2, n_bytes)
