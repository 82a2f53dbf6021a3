"""Which paths lead to a file under a root, and that nothing is told of what lies elsewhere."""

import os
import pickle
from pathlib import Path

import pytest

from primfit.app.agents.roots import PathRefusedError, Roots
from primfit.app.readers.errors import TooLargeError

LIMIT = 100


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A root `in` with a file and a subfolder, and a file beside it."""
    (tmp_path / "in" / "sub").mkdir(parents=True)
    (tmp_path / "in" / "a.csv").write_text("inside")
    (tmp_path / "in" / "sub" / "b.csv").write_text("deep")
    (tmp_path / "secret.csv").write_text("secret")
    return tmp_path


def _read(folder: Path, path: str, *roots: str) -> bytes:
    return Roots.of([folder / root for root in roots or ("in",)]).find(path).read(LIMIT)


def _refusal(folder: Path, path: str, *roots: str) -> str:
    with pytest.raises((PathRefusedError, TooLargeError)) as caught:
        _read(folder, path, *roots)
    return str(caught.value)


def test_files_are_found_by_absolute_and_relative_paths(folder: Path) -> None:
    assert _read(folder, "a.csv") == _read(folder, str(folder / "in" / "a.csv")) == b"inside"
    assert _read(folder, "sub/b.csv") == b"deep"


def test_a_relative_path_begins_in_the_first_root_that_has_it(folder: Path) -> None:
    (folder / "other").mkdir()
    (folder / "other" / "c.csv").write_text("other")
    assert _read(folder, "c.csv", "in", "other") == b"other"
    assert _read(folder, "a.csv", "other", "in") == b"inside"


def test_links_within_the_roots_are_followed(folder: Path) -> None:
    (folder / "in" / "link.csv").symlink_to("sub/b.csv")
    (folder / "root").symlink_to(folder / "in")
    assert _read(folder, "link.csv") == b"deep"
    assert _read(folder, str(folder / "root" / "a.csv"), "root") == b"inside"
    assert _read(folder, str(folder / "in" / "a.csv"), "root") == b"inside"


def test_what_is_there_elsewhere_and_what_is_not_are_refused_alike(folder: Path) -> None:
    (folder / "in" / "out.csv").symlink_to(folder / "secret.csv")
    (folder / "in" / "dangling.csv").symlink_to(folder / "nothing.csv")
    (folder / "in" / "up").symlink_to(folder)
    (folder / "in" / "loop").symlink_to("loop")
    there = [str(folder / "secret.csv"), "../secret.csv", "out.csv", "up/secret.csv", "sub/../../secret.csv"]
    not_there = [str(folder / "nothing.csv"), "../nothing.csv", "dangling.csv", "up/nothing.csv"]
    for path in (*there, *not_there, str(folder / "in" / ".." / "in" / "a.csv"), "", ".", "a\0b"):
        said = _refusal(folder, path)
        assert said.removeprefix(repr(path)) == (
            f" leads to no file under an allowed root, without '..'; allowed are files under {folder / 'in'}"
        )


def test_without_roots_no_path_is_allowed() -> None:
    with pytest.raises(PathRefusedError, match="no root is allowed"):
        Roots().find("/etc/hostname")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes with names")
def test_only_regular_files_are_read(folder: Path) -> None:
    os.mkfifo(folder / "in" / "pipe")
    assert _refusal(folder, "pipe") == "'pipe' is a pipe; a file with a cloud is needed"
    assert _refusal(folder, "sub") == "'sub' is a folder; a file with a cloud is needed"
    assert _refusal(folder, "null", "/dev") == "'null' is a device; a file with a cloud is needed"


def test_missing_and_large_files_are_told_with_the_limit(folder: Path) -> None:
    (folder / "in" / "large.csv").write_bytes(bytes(LIMIT + 1))
    assert _refusal(folder, "none.csv") == "'none.csv' leads to no file"
    assert _refusal(folder, "a.csv/x.csv") == "'a.csv/x.csv' leads to no file"
    assert _refusal(folder, "large.csv") == "'large.csv' holds 101 bytes; the limit is 100 (max_body_bytes)"


def test_a_link_that_is_put_in_place_after_the_check_is_not_followed(folder: Path) -> None:
    roots = Roots.of([folder / "in"])
    file, deep = roots.find("a.csv"), roots.find("sub/b.csv")
    (folder / "in" / "a.csv").unlink()
    (folder / "in" / "a.csv").symlink_to(folder / "secret.csv")
    (folder / "in" / "sub").rename(folder / "moved")
    (folder / "in" / "sub").symlink_to(folder / "moved")
    for found in (file, deep):
        with pytest.raises(PathRefusedError):
            found.read(LIMIT)


def test_a_root_has_to_be_a_folder(folder: Path) -> None:
    with pytest.raises(NotADirectoryError, match="is no folder"):
        Roots.of([folder / "secret.csv"])


def test_a_refusal_can_be_sent_between_processes() -> None:
    error = pickle.loads(pickle.dumps(PathRefusedError("a", "leads to no file")))
    assert (error.field, str(error)) == ("path", "'a' leads to no file")
