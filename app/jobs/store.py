"""The table of the jobs, in SQLite or PostgreSQL; the only place with SQL.

Every change is one short transaction that is safe to be made twice: where a connection breaks, nobody knows
whether the last one was made. An attempt at a job changes its record only while the record has its number
(compare-and-swap), so whoever lost a job to another service is told so by a count of rows that is 0.
"""

import os
import sqlite3
import threading
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection, Engine

from ..readers.errors import TooLargeError
from ..wire.problems import (
    IdempotencyKeyReusedError,
    InsufficientStorageError,
    JobsUnavailableError,
    TooManyJobsError,
)
from .clock import SteadyClock
from .record import ACCEPTED, DISMISSED, ENDED, FAILED, RUNNING, Job, NewJob, Part, Progress
from .watch import Beat

MOST_CRASHES = 5
"""How often services may end over one line of a job, or be taken for dead: it is not begun for ever."""
_BUSY_SECONDS = 3
"""How long a statement waits: a client is told sooner than it gives up, and a beat is not missed for it."""
_FULL = ("SQLITE_FULL", "53100")

_metadata = sa.MetaData()
_big = sa.BigInteger().with_variant(sa.Integer, "sqlite")
_jobs = sa.Table(
    "primfit_jobs",
    _metadata,
    sa.Column("seq", _big, primary_key=True, autoincrement=True),
    sa.Column("id", sa.String, nullable=False, unique=True),
    sa.Column("owner", sa.String, nullable=False),
    sa.Column("key", sa.String),
    sa.Column("fingerprint", sa.String, nullable=False),
    sa.Column("request", sa.JSON, nullable=False),
    sa.Column("n_files", sa.Integer, nullable=False),
    sa.Column("status", sa.String, nullable=False, index=True),
    sa.Column("attempt", sa.Integer, nullable=False, default=0),
    sa.Column("beat", sa.Integer, nullable=False, default=0),
    sa.Column("crashes", sa.Integer, nullable=False, default=0),
    sa.Column("parts", sa.JSON, nullable=False, default=list),
    sa.Column("lines", sa.Integer, nullable=False, default=0),
    sa.Column("percent", sa.Integer, nullable=False, default=0),
    sa.Column("body_bytes", _big, nullable=False),
    sa.Column("result_bytes", _big, nullable=False, default=0),
    sa.Column("created", sa.Double, nullable=False),
    sa.Column("updated", sa.Double, nullable=False),
    sa.Column("started", sa.Double),
    sa.Column("finished", sa.Double),
    sa.Column("expires", sa.Double),
    sa.Column("summary", sa.JSON(none_as_null=True)),
    sa.Column("problem", sa.JSON(none_as_null=True)),
    # Without it SQLite would give the number of a removed job to the next one.
    sa.UniqueConstraint("owner", "key"),
    sqlite_autoincrement=True,
)
_database = sa.Table("primfit_database", _metadata, sa.Column("id", sa.String, primary_key=True))
"""One row, which tells this database from every other one."""


def _anywhere(_database: str, _is_empty: bool) -> None:
    """The check of a database that belongs to no folder."""


class Store:
    """Records of jobs, for several services at once."""

    def __init__(
        self,
        url: str,
        clock: SteadyClock,
        keep: float,
        check: Callable[[str, bool], None] = _anywhere,
    ) -> None:
        """`keep` is how many seconds a job stays after its end.

        `check` is told the id of the database, and whether it has no record, when it is first spoken to;
        while that raises an error, everything does.
        """
        self._clock, self._keep, self._check = clock, keep, check
        self._engine = _engine(url)
        self._writing = self._engine.execution_options(writes=True)
        self._made, self._making = False, threading.Lock()

    def close(self) -> None:
        self._engine.dispose()

    def open(self) -> None:
        """Speak to the database, and check that it is the right one."""
        with self._reading():
            pass

    def add(self, new: NewJob, most_jobs: int, most_bytes: int) -> Job:
        """Keep a new job; where its owner sent one under the same key before, that one.

        Raises
        ------
        IdempotencyKeyReusedError
            The one under the same key was another one.
        TooManyJobsError
            The owner would have more jobs, or bytes in them, than so many.
        TooLargeError
            This one alone has more.
        """
        with self._transaction() as connection:
            if connection.dialect.name == "postgresql":
                # One at a time for each owner; the writers of SQLite wait for each other anyhow.
                connection.execute(sa.select(sa.func.pg_advisory_xact_lock(sa.func.hashtext(new.owner))))
            earlier = self._earlier(connection, new, most_jobs, most_bytes)
            if earlier is not None:
                return earlier
            now = self._clock()
            # One whose time has come gives its key away before it is removed.
            given_up = _jobs.update().where(_jobs.c.owner == new.owner, _jobs.c.key == new.key)
            connection.execute(given_up.values(key=None))
            values = {
                "id": new.id,
                "owner": new.owner,
                "key": new.key,
                "fingerprint": new.fingerprint,
                "request": dict(new.request),
                "n_files": new.n_files,
                "status": ACCEPTED,
                "body_bytes": new.bytes,
                "created": now,
                "updated": now,
            }
            connection.execute(_jobs.insert().values(values))
            return _one(connection, _jobs.c.id == new.id)

    def earlier(self, new: NewJob, most_jobs: int, most_bytes: int) -> Job | None:
        """The job that its owner sent under the same key; None where `add` would keep this one."""
        with self._reading() as connection:
            return self._earlier(connection, new, most_jobs, most_bytes)

    def _earlier(self, connection: Connection, new: NewJob, most_jobs: int, most_bytes: int) -> Job | None:
        mine = (_jobs.c.owner == new.owner, self._is_kept())
        if new.key is not None:
            same = _jobs.select().where(*mine, _jobs.c.key == new.key)
            found = _job(connection.execute(same).one_or_none())
            if found is not None and found.fingerprint != new.fingerprint:
                raise IdempotencyKeyReusedError(
                    "a job with another body or other options came with this key; a new job needs a new one"
                )
            if found is not None:
                return found
        held = sa.cast(sa.func.coalesce(sa.func.sum(_jobs.c.body_bytes + _jobs.c.result_bytes), 0), _big)
        n_jobs, n_bytes = connection.execute(sa.select(sa.func.count(), held).where(*mine)).one()
        if n_jobs >= most_jobs:
            raise TooManyJobsError(
                f"{n_jobs} jobs are kept for you, and {most_jobs} is the limit; remove one with DELETE"
            )
        if new.bytes > most_bytes:
            size = f"{new.bytes} bytes"
            raise TooLargeError("body", f"{size}; your jobs may hold {most_bytes}", size)
        if n_bytes + new.bytes > most_bytes:
            raise TooManyJobsError(
                f"your jobs hold {n_bytes} bytes and this one {new.bytes}, and {most_bytes} is the limit; "
                "remove one with DELETE"
            )
        return None

    def find(self, job_id: str, owner: str | None = None) -> Job | None:
        """The job of this id, where it is that of this owner; None asks for no owner."""
        if "\0" in job_id:  # which PostgreSQL does not take for text
            return None
        mine = sa.true() if owner is None else _jobs.c.owner == owner
        found = _jobs.select().where(_jobs.c.id == job_id, mine, self._is_kept())
        with self._reading() as connection:
            return _job(connection.execute(found).one_or_none())

    def listed(self, owner: str | None = None) -> list[Job]:
        """The jobs of this owner, or all of them, in the order in which they came."""
        mine = sa.true() if owner is None else _jobs.c.owner == owner
        found = _jobs.select().where(mine, self._is_kept()).order_by(_jobs.c.seq)
        with self._reading() as connection:
            rows = connection.execute(found).all()
        return [job for row in rows if (job := _job(row)) is not None]

    def _is_kept(self) -> Any:
        """Whether the time of a job has not come yet: from then on it is gone, removed or not."""
        return sa.or_(_jobs.c.expires.is_(None), _jobs.c.expires > self._clock())

    def ids(self) -> set[str]:
        """Those of all jobs."""
        with self._reading() as connection:
            return set(connection.execute(sa.select(_jobs.c.id)).scalars())

    def place(self, job: Job) -> int:
        """How many jobs that wait came before this one, and itself."""
        with self._reading() as connection:
            waiting = sa.select(sa.func.count()).where(_jobs.c.status == ACCEPTED, _jobs.c.seq <= job.seq)
            return int(connection.execute(waiting).scalar_one())

    def claim(self, begun: bool = False) -> Job | None:
        """Begin the next job that waits: of the owner with the fewest under way, the one that came first.

        `begun` asks only for those that were begun before, and let go.
        """
        others = _jobs.alias()
        under_way = (
            sa.select(sa.func.count())
            .where(others.c.owner == _jobs.c.owner, others.c.status == RUNNING)
            .scalar_subquery()
        )
        next_one = (
            sa.select(_jobs.c.id, _jobs.c.attempt)
            .where(_jobs.c.status == ACCEPTED, _jobs.c.attempt > 0 if begun else sa.true())
            .order_by(under_way, _jobs.c.seq)
            .limit(1)
            .with_for_update(skip_locked=True, of=_jobs)
        )
        with self._transaction() as connection:
            found = connection.execute(next_one).one_or_none()
            if found is None:
                return None
            return self._begin(connection, *found, {})

    def beats(self) -> list[Beat]:
        """The last sign of life of each job that is worked on."""
        running = sa.select(_jobs.c.id, _jobs.c.attempt, _jobs.c.beat).where(_jobs.c.status == RUNNING)
        with self._reading() as connection:
            return [Beat(*row) for row in connection.execute(running)]

    def take_over(self, silent: Beat, problem: Mapping[str, Any]) -> Job | None:
        """Go on with the job of a service that went silent, unless somebody else does or it spoke again.

        Where services went silent over it too often, it fails with this problem.
        """
        same = (
            _jobs.c.id == silent.job_id,
            _jobs.c.attempt == silent.attempt,
            _jobs.c.beat == silent.beat,
            _jobs.c.status == RUNNING,
        )
        with self._transaction() as connection:
            found = connection.execute(
                sa.select(_jobs.c.crashes).where(*same).with_for_update(skip_locked=True)
            ).one_or_none()
            if found is None:
                return None
            if found.crashes + 1 >= MOST_CRASHES:
                self._end(connection, same, FAILED, {"problem": dict(problem)})
                return None
            return self._begin(connection, silent.job_id, silent.attempt, {"crashes": found.crashes + 1})

    def _begin(self, connection: Connection, job_id: str, attempt: int, values: dict[str, Any]) -> Job | None:
        now = self._clock()
        values |= {"status": RUNNING, "attempt": attempt + 1, "beat": 0, "updated": now}
        mine = (_jobs.c.id == job_id, _jobs.c.attempt == attempt)
        values["started"] = sa.func.coalesce(_jobs.c.started, now)
        done = connection.execute(_jobs.update().where(*mine).values(values))
        return _one(connection, _jobs.c.id == job_id) if done.rowcount else None

    def keep(self, job: Job, beat: int, progress: Progress) -> bool:
        """Note a sign of life and what is told so far; False where the job is no longer this attempt's."""
        values = _columns(progress) | {"beat": beat, "updated": self._clock()}
        values["crashes"] = sa.case((_jobs.c.lines == progress.lines, _jobs.c.crashes), else_=0)
        with self._transaction() as connection:
            return bool(connection.execute(_jobs.update().where(*_held(job)).values(values)).rowcount)

    def release(self, job: Job, progress: Progress) -> bool:
        """Let others go on with it at once."""
        values = _columns(progress) | {"status": ACCEPTED, "updated": self._clock()}
        with self._transaction() as connection:
            return bool(connection.execute(_jobs.update().where(*_held(job)).values(values)).rowcount)

    def end(
        self,
        job: Job,
        progress: Progress,
        status: str,
        summary: Mapping[str, int] | None = None,
        problem: Mapping[str, Any] | None = None,
    ) -> bool:
        """It has ended; False where it was no longer this attempt's."""
        values = _columns(progress) | {"summary": summary, "problem": problem}
        with self._transaction() as connection:
            return self._end(connection, _held(job), status, values)

    def dismiss(self, job_id: str) -> bool:
        """Cancel a job that has not ended; whoever works on it finds that it is no longer his."""
        open_one = (_jobs.c.id == job_id, _jobs.c.status.not_in(ENDED))
        with self._transaction() as connection:
            return self._end(connection, open_one, DISMISSED, {})

    def _end(
        self, connection: Connection, which: tuple[Any, ...], status: str, values: dict[str, Any]
    ) -> bool:
        now = self._clock()
        values |= {"status": status, "updated": now, "finished": now, "expires": now + self._keep}
        values["body_bytes"] = 0  # nobody needs the body any more: it is removed
        return bool(connection.execute(_jobs.update().where(*which).values(values)).rowcount)

    def remove(self, job_id: str) -> None:
        """Forget a job that has ended."""
        with self._transaction() as connection:
            connection.execute(_jobs.delete().where(_jobs.c.id == job_id, _jobs.c.status.in_(ENDED)))

    def expired(self) -> list[str]:
        """The ids of the jobs that were kept for long enough."""
        with self._reading() as connection:
            gone = sa.select(_jobs.c.id).where(sa.not_(self._is_kept()))
            return list(connection.execute(gone).scalars())

    @contextmanager
    def _transaction(self) -> Iterator[Connection]:
        """All or nothing; the disk holds it when this is left."""
        with _answered():
            self._make_once()
            with self._writing.begin() as connection:
                yield connection

    @contextmanager
    def _reading(self) -> Iterator[Connection]:
        with _answered():
            self._make_once()
            with self._engine.connect() as connection:
                yield connection

    def _make_once(self) -> None:
        """The table, when the database is first spoken to: the service starts where this is down, too."""
        with self._making:
            if self._made:
                return
            with self._writing.begin() as connection:
                if connection.dialect.name == "postgresql":
                    # Two services that start together would both find none.
                    connection.execute(sa.select(sa.func.pg_advisory_xact_lock(sa.func.hashtext("primfit"))))
                _metadata.create_all(connection)
                found = connection.execute(sa.select(_database.c.id)).scalar_one_or_none()
                if found is None:
                    found = str(uuid.uuid4())
                    connection.execute(_database.insert().values(id=found))
                is_empty = connection.execute(sa.select(_jobs.c.id).limit(1)).first() is None
            self._check(found, is_empty)
            self._made = True


def sqlite_url(folder: Path) -> str:
    """The database in the folder of the jobs."""
    return sa.URL.create("sqlite", database=str(folder / "jobs.sqlite")).render_as_string()


def _engine(url: str) -> Engine:
    parsed = sa.make_url(url)
    if parsed.get_backend_name() == "sqlite":
        # Its user's only, as the folder that is made for it; the files beside it get the same rights.
        os.close(os.open(str(parsed.database), os.O_RDWR | os.O_CREAT, 0o600))
        engine = sa.create_engine(parsed, connect_args={"timeout": _BUSY_SECONDS})
        sa.event.listen(engine, "connect", _set_up_sqlite)
        sa.event.listen(engine, "begin", _begin_sqlite)
        return engine
    # Whatever hangs ends: a statement, a lock, and a peer that does not answer any more.
    limit = 1000 * _BUSY_SECONDS
    arguments = {
        "connect_timeout": _BUSY_SECONDS,
        "tcp_user_timeout": limit,
        "options": f"-c statement_timeout={limit} -c idle_in_transaction_session_timeout={limit}",
    }
    return sa.create_engine(
        parsed.set(drivername="postgresql+psycopg"), pool_pre_ping=True, connect_args=arguments
    )


def _set_up_sqlite(connection: Any, _: object) -> None:
    """Readers do not wait for a writer (WAL), and what is committed is on the disk (FULL)."""
    connection.isolation_level = None  # Python begins no transactions of its own
    for pragma in ("journal_mode=WAL", "synchronous=FULL"):
        connection.execute(f"PRAGMA {pragma}")


def _begin_sqlite(connection: Connection) -> None:
    """A writer waits for its turn at the beginning, where waiting helps."""
    writes = connection.get_execution_options().get("writes", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


@contextmanager
def _answered() -> Iterator[None]:
    """What databases complain of, in our words."""
    try:
        yield
    except sa.exc.DBAPIError as error:
        code = getattr(error.orig, "sqlite_errorname", None) or getattr(error.orig, "sqlstate", None)
        if code in _FULL:
            raise InsufficientStorageError("the disk for jobs is full; try again later") from error
        if isinstance(error, sa.exc.IntegrityError | sa.exc.DataError) and not error.connection_invalidated:
            raise  # what we asked for was wrong, and would be again
        raise JobsUnavailableError("the database of the jobs does not answer; try again") from error
    except (sa.exc.TimeoutError, sqlite3.DatabaseError) as error:
        # All connections are in use; or one to a database that is locked, or none, could not be set up.
        raise JobsUnavailableError("the database of the jobs does not answer; try again") from error


def told(error: BaseException) -> str:
    """Our words and, behind them, what the database itself said, in one line; it knows no password."""
    cause = error.__cause__
    reason = " ".join(str(getattr(cause, "orig", None) or cause or "").split())
    return f"{error} ({reason})" if reason else str(error)


def _held(job: Job) -> tuple[Any, ...]:
    """Where the record still is that of this attempt."""
    return _jobs.c.id == job.id, _jobs.c.attempt == job.attempt, _jobs.c.status == RUNNING


def _columns(progress: Progress) -> dict[str, Any]:
    return {
        "parts": [[part.attempt, part.lines, part.bytes] for part in progress.parts],
        "lines": progress.lines,
        "percent": progress.percent,
        "result_bytes": sum(part.bytes for part in progress.parts),
    }


def _one(connection: Connection, which: Any) -> Job:
    job = _job(connection.execute(_jobs.select().where(which)).one())
    assert job is not None
    return job


def _job(row: Any) -> Job | None:
    if row is None:
        return None
    given = dict(row._mapping)
    parts = tuple(Part(*part) for part in given["parts"])
    progress = Progress(parts, given["lines"], given["percent"])
    n_bytes = given["body_bytes"] + given["result_bytes"]
    rest = {name: given[name] for name in Job.__dataclass_fields__ if name not in ("progress", "bytes")}
    return Job(**rest, progress=progress, bytes=n_bytes)
