"""Temporary files: none outlives the request that it was made for."""

from pathlib import Path

import pytest

from primfit.app.service.spool import Spool


def test_files_go_with_their_request_and_none_is_made_after_it(tmp_path: Path) -> None:
    """A batch that is given up may just have begun to read its next file."""
    with Spool(tmp_path, None, 1).files() as file:
        made = [Path(file().name) for _ in range(3)]
        assert all(path.exists() for path in made)
    with pytest.raises(ValueError, match="has ended"):
        file()
    assert not list(tmp_path.iterdir())
