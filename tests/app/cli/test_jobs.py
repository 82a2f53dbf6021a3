"""`primfit jobs` lists, cancels and cleans what services keep."""

import os
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from primfit.app.cli.commands import app
from primfit.app.jobs.desk import Desk
from primfit.app.jobs.files import WrongDatabaseError
from primfit.app.jobs.store import Store
from primfit.app.service import jobs_kept, server
from primfit.app.service.jobs_kept import open_desk
from primfit.app.service.settings import Settings, SettingsError
from primfit.app.wire.problems import InsufficientStorageError
from tests.app.jobs.making import MANY, new


def run(*args: str) -> Result:
    return CliRunner().invoke(app, ["jobs", *args])


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Desk:
    """The jobs of a service on the folder that is set."""
    monkeypatch.setenv("PRIMFIT_JOBS_PATH", str(tmp_path / "jobs"))
    opened = open_desk(Settings(jobs_path=tmp_path / "jobs"))
    opened.store.open()
    return opened


def _keep(desk: Desk, owner: str) -> str:
    made = new(owner)
    desk.folder.create(made.id, b"the body")
    return desk.store.add(made, MANY, MANY).id


def test_jobs_are_listed_canceled_and_removed(desk: Desk) -> None:
    first, second = _keep(desk, "alice"), _keep(desk, "")
    lines = run("list").stdout.splitlines()
    assert [line.split()[:3] for line in lines] == [
        [first, "alice", "accepted"],
        [second, "-", "accepted"],
    ]
    assert run("cancel", first).exit_code == 0
    assert run("list").stdout.splitlines()[0].split()[2] == "dismissed"
    assert run("cancel", first, second).exit_code == 0
    assert [line.split()[0] for line in run("list").stdout.splitlines()] == [second]
    assert run("clean").stdout.startswith("0 jobs removed")
    assert run("clean", "--ended").stdout.startswith("1 jobs removed")
    assert run("list").stdout == "" and desk.folder.ids() == set()


def test_those_that_there_are_are_canceled_beside_one_that_there_is_not(desk: Desk) -> None:
    first, second = _keep(desk, "alice"), _keep(desk, "")
    done = run("cancel", first, "nobody", second)
    assert (done.exit_code, done.stderr) == (2, "primfit: jobs: nobody: no such job\n")
    assert [line.split()[2] for line in run("list").stdout.splitlines()] == ["dismissed", "dismissed"]


def test_a_folder_is_not_made_for_who_mistypes_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PRIMFIT_JOBS_PATH", str(tmp_path / "jbos"))
    done = run("list")
    assert done.exit_code == 2 and "no such folder (jobs_path)" in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_full_disk_is_told_in_a_sentence_and_can_be_cleaned(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The database takes no change until files are removed."""
    waiting, ended = _keep(desk, "alice"), _keep(desk, "alice")
    assert run("cancel", ended).exit_code == 0
    full = InsufficientStorageError("the disk for jobs is full; try again later")
    there = desk.folder.of(waiting).body

    def as_on_a_full_disk(name: str) -> None:
        change = getattr(Store, name)

        def changed(store: Store, job_id: str) -> Any:
            if there.exists():
                raise full
            return change(store, job_id)

        monkeypatch.setattr(Store, name, changed)

    for name in ("remove", "dismiss"):
        as_on_a_full_disk(name)
    done = run("clean", "--ended")
    assert (done.exit_code, done.stderr) == (1, f"primfit: jobs: {full}\n")
    assert desk.folder.ids() == {waiting}
    assert run("cancel", waiting).exit_code == 0 and not there.exists()
    assert run("clean", "--ended").stdout.startswith("2 jobs removed")


def test_files_of_no_job_are_removed_when_nobody_can_be_taking_them_in(desk: Desk) -> None:
    kept = _keep(desk, "alice")
    for stray in ("old", "young"):
        desk.folder.create(stray, b"the body")
    os.utime(desk.folder.of("old").folder, (0, 0))
    os.utime(desk.folder.of(kept).folder, (0, 0))
    assert run("clean").stdout == "0 jobs removed, and the files of 1 that no record names\n"
    assert desk.folder.ids() == {kept, "young"}


def test_nothing_is_removed_where_the_database_is_not_that_of_the_folder(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = _keep(desk, "alice")
    os.utime(desk.folder.of(kept).folder, (0, 0))
    desk.close()
    (desk.folder.path / "jobs.sqlite").rename(
        desk.folder.path / "set aside"
    )  # as if jobs_database was forgotten
    for _ in range(2):
        for command in (("clean",), ("clean", "--ended"), ("list",), ("cancel", kept)):
            done = run(*command)
            assert done.exit_code == 2
            assert "jobs_path and jobs_database do not belong together" in done.stderr
    assert desk.folder.of(kept).body.read_bytes() == b"the body"
    for at_start in (jobs_kept.check_database, lambda settings: server.serve(None, 0, None, demo=False)):
        with pytest.raises((WrongDatabaseError, SettingsError), match="jobs_path and jobs_database"):
            at_start(Settings(jobs_path=desk.folder.path))
    (desk.folder.path / "set aside").rename(desk.folder.path / "jobs.sqlite")
    assert run("list").stdout.split()[0] == kept


def test_a_folder_without_its_note_is_refused_where_there_are_jobs(desk: Desk) -> None:
    _keep(desk, "alice")
    (desk.folder.path / "database").unlink()
    assert run("list").exit_code == 2  # as where the volume of the jobs is not mounted


def test_what_cannot_be_done_is_told(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    done = run("cancel", "nothing")
    assert (done.exit_code, done.stderr) == (2, "primfit: jobs: nothing: no such job\n")
    monkeypatch.setenv("PRIMFIT_JOBS_DATABASE", "postgresql://primfit:geheim@127.0.0.1:1/jobs")
    done = run("list")
    assert done.exit_code == 1 and "onnection refused" in done.stderr and "geheim" not in done.stderr
    for port in ("abc", "0", "70000"):
        monkeypatch.setenv("PRIMFIT_JOBS_DATABASE", f"postgresql://primfit:geheim@127.0.0.1:{port}/jobs")
        done = run("list")
        assert done.exit_code == 2 and "PORT is" in done.stderr and "geheim" not in done.stderr
    monkeypatch.setenv("PRIMFIT_JOBS_DATABASE", "mysql://127.0.0.1/jobs")
    done = run("list")
    assert done.exit_code == 2 and "postgresql://USER" in done.stderr and "mysql" not in done.stderr
    monkeypatch.delenv("PRIMFIT_JOBS_DATABASE")
    monkeypatch.delenv("PRIMFIT_JOBS_PATH")
    done = run("list")
    assert done.exit_code == 2 and "jobs_path is not set" in done.stderr
