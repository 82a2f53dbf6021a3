"""Exports are whole or not there, and replace nothing unasked."""

import os
from dataclasses import replace
from pathlib import Path

import pytest

from primfit.app.agents.output import Output, name_of
from primfit.app.wire.problems import InsufficientStorageError, InvalidOptionsError


@pytest.fixture
def output(tmp_path: Path) -> Output:
    return Output(tmp_path, "pipe", owner=1)


def test_a_file_is_written_once(output: Output) -> None:
    output.check(["step"])
    told = output.write("step", b"first")
    assert told == {"artifact": "step", "path": str(output.folder / "pipe-primitive.step"), "n_bytes": 5}
    for again in (lambda: output.check(["step"]), lambda: output.write("step", b"second")):
        with pytest.raises(InvalidOptionsError, match="exists; give `overwrite: true`"):
            again()
    assert [file.read_bytes() for file in output.folder.iterdir()] == [b"first"]


def test_it_is_replaced_where_that_is_asked_for(output: Output) -> None:
    output.write("step", b"first")
    replace(output, overwrite=True).write("step", b"second")
    assert [file.read_bytes() for file in output.folder.iterdir()] == [b"second"]


def test_without_second_names_for_files_nothing_is_replaced_either(
    output: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError("no links here")

    monkeypatch.setattr(os, "link", refuse)
    output.write("step", b"first")
    with pytest.raises(InvalidOptionsError, match="exists"):
        output.write("step", b"second")
    assert [file.read_bytes() for file in output.folder.iterdir()] == [b"first"]


def test_the_cloud_is_never_overwritten(output: Output) -> None:
    cloud = output.target("residuals_ply")
    cloud.write_bytes(b"cloud")
    with pytest.raises(InvalidOptionsError, match="is the file that is read"):
        replace(output, overwrite=True, source=cloud).check(["residuals_ply"])


def test_a_link_is_replaced_and_not_followed(
    output: Output, tmp_path_factory: pytest.TempPathFactory
) -> None:
    elsewhere = tmp_path_factory.mktemp("elsewhere") / "file"
    elsewhere.write_bytes(b"untouched")
    output.target("step").symlink_to(elsewhere)
    with pytest.raises(InvalidOptionsError, match="exists"):
        output.check(["step"])
    replace(output, overwrite=True).write("step", b"new")
    assert elsewhere.read_bytes() == b"untouched" and output.target("step").read_bytes() == b"new"


def test_where_nothing_can_be_written_nothing_is_left(output: Output) -> None:
    output.target("step").mkdir()
    with pytest.raises(InsufficientStorageError, match="cannot be written now"):
        replace(output, overwrite=True).write("step", b"new")
    assert [file.name for file in output.folder.iterdir()] == ["pipe-primitive.step"]


def test_names_come_from_the_cloud_or_as_given() -> None:
    assert name_of(None, "scan.csv.gz") == "scan"
    assert name_of(None, None) == "cloud"
    assert name_of("part 7", "scan.csv") == "part 7"
    for bad in ("", "../x", "a/b", "a\\b", "x" * 81, "a\n", ".hidden."):
        with pytest.raises(InvalidOptionsError, match="name"):
            name_of(bad, None)
