"""Empty stores: in SQLite, and in a real PostgreSQL where there is one."""

import itertools
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from primfit.app.jobs.clock import SteadyClock
from primfit.app.jobs.store import Store, sqlite_url
from tests.app.postgresql import Postgres, needs_postgres, started

Open = Callable[..., Store]
_numbers = itertools.count(1)


@pytest.fixture(scope="session")
def postgres() -> Iterator[Postgres]:
    with started() as server:
        yield server


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=needs_postgres)])
def open_store(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Open]:
    """Opens the same new database once more with each call, as another service would."""
    if request.param == "sqlite":
        url = sqlite_url(tmp_path)
    else:
        url = request.getfixturevalue("postgres").create(f"jobs_{next(_numbers)}")
    opened: list[Store] = []

    def open_it(clock: SteadyClock | None = None, keep: float = 86400.0) -> Store:
        opened.append(Store(url, clock or SteadyClock(), keep))
        return opened[-1]

    yield open_it
    for store in opened:
        store.close()
