"""What a store of jobs promises, over each database: nothing is lost, and nobody has what another one has."""

import sqlite3
import threading
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from primfit.app.jobs.clock import SteadyClock
from primfit.app.jobs.record import FAILED, RUNNING, SUCCESSFUL, Job, Part, Progress
from primfit.app.jobs.store import MOST_CRASHES, Store, sqlite_url
from primfit.app.jobs.watch import Beat
from primfit.app.readers.errors import TooLargeError
from primfit.app.wire.problems import (
    IdempotencyKeyReusedError,
    JobsUnavailableError,
    TooManyJobsError,
)
from tests.app.jobs.making import MANY, new

PROBLEM = {"type": "urn:primfit:problem:worker-died"}
SOME = Progress((Part(1, 3, 300),), 3, 40)


def _claimed(store: Store) -> Job:
    job = store.claim()
    assert job is not None
    return job


def _beat(store: Store) -> Beat:
    (beat,) = store.beats()
    return beat


def test_a_job_is_found_by_its_owner_only(open_store: Any) -> None:
    store, other = open_store(), open_store()
    made = new()
    kept = store.add(made, 9, MANY)
    assert kept == other.find(made.id, "alice") == other.find(made.id)
    assert (kept.status, kept.request, kept.n_files, kept.bytes) == ("accepted", made.request, 2, 10)
    assert other.find(made.id, "bob") is None
    assert (other.listed("alice"), other.listed("bob"), other.listed()) == ([kept], [], [kept])
    assert other.ids() == {made.id}


def test_no_job_has_an_id_that_is_no_text(open_store: Any) -> None:
    assert open_store().find("a\0b", "alice") is None


def test_a_job_that_is_larger_than_all_may_be_is_refused_for_good(open_store: Any) -> None:
    with pytest.raises(TooLargeError, match="11 bytes; your jobs may hold 10"):
        open_store().add(new(n_bytes=11), 9, 10)


def test_the_same_key_brings_the_same_job(open_store: Any) -> None:
    store = open_store()
    first = store.add(new(key="k"), 1, MANY)
    assert store.add(new(key="k"), 1, MANY) == first == store.earlier(new(key="k"), 1, MANY)
    with pytest.raises(IdempotencyKeyReusedError):
        store.add(new(key="k", fingerprint="other"), 9, MANY)
    assert store.add(new(key="k", owner="bob"), 1, MANY).id != first.id


def test_jobs_and_bytes_of_an_owner_are_bounded(open_store: Any) -> None:
    store = open_store()
    store.add(new(n_bytes=60), 2, 100)
    with pytest.raises(TooManyJobsError, match="60 bytes and this one 41, and 100 is the limit"):
        store.add(new(n_bytes=41), 2, 100)
    store.add(new(n_bytes=40), 2, 100)
    with pytest.raises(TooManyJobsError, match="2 jobs are kept for you, and 2 is the limit"):
        store.add(new(n_bytes=0), 2, 100)
    store.add(new(owner="bob", n_bytes=100), 2, 100)


def test_jobs_are_begun_in_order_but_first_of_those_with_fewer_under_way(open_store: Any) -> None:
    store = open_store()
    first, second, third, bobs = (store.add(new(owner), 9, MANY) for owner in ("a", "a", "a", "b"))
    assert [store.place(job) for job in (first, third, bobs)] == [1, 3, 4]
    begun = [_claimed(store).id for _ in range(4)]
    assert begun == [first.id, bobs.id, second.id, third.id]
    assert store.claim() is None


def test_services_that_look_at_once_never_begin_the_same_job(open_store: Any) -> None:
    stores, n_jobs = [open_store() for _ in range(4)], 24
    made = {stores[0].add(new(), MANY, MANY).id for _ in range(n_jobs)}
    begun: list[str] = []

    def work(store: Store) -> None:
        while len(begun) < n_jobs:
            with suppress(JobsUnavailableError):  # others were faster for a while: it is asked again
                if (job := store.claim()) is not None:
                    begun.append(job.id)

    threads = [threading.Thread(target=work, args=(store,)) for store in stores]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert Counter(begun) == Counter(made)


def test_a_sign_of_life_tells_how_far_a_job_is(open_store: Any) -> None:
    store = open_store()
    store.add(new(), 9, MANY)
    job = _claimed(store)
    assert (job.status, job.attempt, job.started is None) == (RUNNING, 1, False)
    assert store.keep(job, 7, SOME)
    found = store.find(job.id)
    assert (found.progress, found.beat, found.bytes) == (SOME, 7, 310)
    assert _beat(store) == Beat(job.id, 1, 7)


def test_a_job_is_taken_over_once_and_its_former_attempt_changes_nothing(open_store: Any) -> None:
    store, other = open_store(), open_store()
    store.add(new(), 9, MANY)
    job = _claimed(store)
    store.keep(job, 1, SOME)
    silent = _beat(other)
    assert other.take_over(Beat(job.id, 1, 0), PROBLEM) is None  # it spoke again
    taken = other.take_over(silent, PROBLEM)
    assert (taken.attempt, taken.progress, taken.started) == (2, SOME, job.started)
    assert store.take_over(silent, PROBLEM) is None
    assert not store.keep(job, 2, Progress())
    assert not store.release(job, Progress())
    assert not store.end(job, Progress(), SUCCESSFUL)
    assert other.find(job.id) == taken


def test_what_may_have_been_made_is_made_again_without_harm(open_store: Any) -> None:
    store = open_store()
    store.add(new(), 9, MANY)
    job = _claimed(store)
    assert store.keep(job, 1, SOME) and store.keep(job, 1, SOME)
    assert store.find(job.id).progress == SOME
    assert store.end(job, SOME, SUCCESSFUL) and not store.end(job, SOME, SUCCESSFUL)


def test_a_job_that_is_let_go_waits_again_with_what_is_told(open_store: Any) -> None:
    store = open_store()
    store.add(new(), 9, MANY)
    assert store.release(_claimed(store), SOME)
    store.add(new("bob"), 9, MANY)
    again = store.claim(begun=True)
    assert again is not None and store.claim(begun=True) is None
    assert (again.attempt, again.progress) == (2, SOME)


def test_a_job_that_breaks_services_fails_unless_it_gets_on(open_store: Any) -> None:
    store = open_store()
    store.add(new(), 9, MANY)
    job: Any = _claimed(store)
    for n_lines in range(2 * MOST_CRASHES):
        job = store.take_over(_beat(store), PROBLEM)
        assert store.keep(job, 1, Progress((), n_lines + 1, 0))
    for _ in range(MOST_CRASHES - 1):
        job = store.take_over(_beat(store), PROBLEM)
        assert job is not None
    assert store.take_over(_beat(store), PROBLEM) is None
    found = store.find(job.id)
    assert (found.status, found.problem, found.progress.lines) == (FAILED, PROBLEM, 2 * MOST_CRASHES)


def test_a_job_that_is_canceled_is_nobodys(open_store: Any) -> None:
    store = open_store()
    store.add(new(), 9, MANY)
    job = _claimed(store)
    assert store.dismiss(job.id)
    assert not store.keep(job, 1, SOME)
    assert not store.dismiss(job.id)
    assert store.find(job.id).status == "dismissed"
    assert store.claim() is None and store.beats() == []


def test_a_job_is_removed_after_its_end_only(open_store: Any) -> None:
    store = open_store()
    made = store.add(new(), 9, MANY)
    store.remove(made.id)
    assert store.ids() == {made.id}
    store.end(_claimed(store), SOME, SUCCESSFUL, {"items": 2})
    assert store.find(made.id).summary == {"items": 2}
    store.remove(made.id)
    assert store.ids() == set()


def test_a_job_expires_after_its_end_and_gives_its_key_and_room_away(open_store: Any) -> None:
    now = 1000.0
    store = open_store(SteadyClock(lambda: 0.0, lambda: now), keep=60.0)
    first = store.add(new(key="k", fingerprint="one"), 1, MANY)
    now += 1e6
    assert store.expired() == []  # it waits still
    store.end(_claimed(store), SOME, SUCCESSFUL)
    now += 59.0
    ended = store.find(first.id)
    assert ended.expires - ended.finished == 60.0
    now += 2.0
    assert store.find(first.id) is None and store.listed() == []
    assert store.expired() == [first.id]
    assert store.add(new(key="k", fingerprint="two"), 1, MANY).id != first.id


def test_a_clock_that_is_set_moves_no_time_of_a_job(open_store: Any) -> None:
    wall, steady = 1e9, 0.0
    store = open_store(SteadyClock(lambda: wall, lambda: steady), keep=60.0)
    store.add(new(), 9, MANY)
    store.end(_claimed(store), SOME, SUCCESSFUL)
    wall += 1e7
    assert store.expired() == []
    wall -= 2e7
    steady += 61.0
    assert len(store.expired()) == 1


def test_numbers_are_not_given_twice(open_store: Any) -> None:
    store = open_store()
    first = store.add(new(), 9, MANY)
    store.dismiss(first.id)
    store.remove(first.id)
    assert store.add(new(), 9, MANY).seq > first.seq


def test_a_database_keeps_its_id_and_is_checked_until_it_is_the_right_one(open_store: Any) -> None:
    told: list[tuple[str, bool]] = []

    def refuse(database: str, is_empty: bool) -> None:
        told.append((database, is_empty))
        raise JobsUnavailableError("another one")

    store = open_store()
    store._check = refuse
    for _ in range(2):
        with pytest.raises(JobsUnavailableError, match="another one"):
            store.ids()
    open_store().add(new(), 9, MANY)
    with pytest.raises(JobsUnavailableError, match="another one"):
        store.open()
    assert told == [(told[0][0], True)] * 2 + [(told[0][0], False)]


def test_others_on_the_machine_may_not_read_the_records(tmp_path: Path) -> None:
    tmp_path.chmod(0o755)
    store = Store(sqlite_url(tmp_path), SteadyClock(), 60.0)
    store.add(new(), 9, MANY)
    modes = {path.name: path.stat().st_mode & 0o777 for path in tmp_path.iterdir()}
    assert modes == dict.fromkeys(("jobs.sqlite", "jobs.sqlite-wal", "jobs.sqlite-shm"), 0o600)
    store.close()


def test_a_locked_database_is_told_and_works_when_it_is_free(tmp_path: Path) -> None:
    store = Store(sqlite_url(tmp_path), SteadyClock(), 60.0)
    kept = store.add(new(), 9, MANY)
    locker = sqlite3.connect(tmp_path / "jobs.sqlite", isolation_level=None)
    locker.execute("BEGIN EXCLUSIVE")
    with pytest.raises(JobsUnavailableError):
        store.add(new(), 9, MANY)
    assert store.find(kept.id) == kept  # readers do not wait
    locker.execute("COMMIT")
    locker.close()
    store.add(new(), 9, MANY)
    store.close()


def test_a_database_that_is_not_there_is_told() -> None:
    store = Store("postgresql://primfit@127.0.0.1:1/jobs", SteadyClock(), 60.0)
    with pytest.raises(JobsUnavailableError):
        store.claim()
    store.close()


def test_sqlite_keeps_what_it_has_committed_through_a_loss_of_power(tmp_path: Path) -> None:
    store = Store(sqlite_url(tmp_path), SteadyClock(), 60.0)
    with store._transaction() as connection:
        modes = [
            connection.exec_driver_sql(f"PRAGMA {name}").scalar() for name in ("journal_mode", "synchronous")
        ]
    assert modes == ["wal", 2]
    store.close()
