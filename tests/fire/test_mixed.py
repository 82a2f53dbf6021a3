"""What `tests.fire.mixed` does for twenty minutes, for a shorter time."""

from pathlib import Path

import pytest

from tests.app.processes import needs_proc
from tests.fire.mixed import mixed_load
from tests.fire.report import reported
from tests.fire.scale import scaled

pytestmark = [pytest.mark.fire, needs_proc]

MINUTES = 1.5


def test_it_does_not_grow_in_two_of_three_runs(tmp_path: Path) -> None:
    held: list[bool] = []
    while held.count(True) < 2:
        with reported(f"mixed-{len(held) + 1}") as figures:
            folder = tmp_path / str(len(held))
            folder.mkdir()
            held.append(mixed_load(figures, folder, scaled(MINUTES)))
        assert held.count(False) < 2, "it grew in two runs"
