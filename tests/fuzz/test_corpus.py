"""What is kept of fuzzing, and the seeds, hold what every input must hold; no fuzzer is needed for that."""

from contextlib import suppress
from pathlib import Path

import pytest

from primfit.app.readers import UnreadableFileError
from tests.fuzz.checked import check
from tests.fuzz.seeds import SEEDS
from tests.fuzz.targets import TARGETS

KEPT = Path(__file__).with_name("corpus")


def test_each_target_has_seeds() -> None:
    assert SEEDS.keys() == TARGETS.keys()


@pytest.mark.parametrize("name", TARGETS)
def test_every_input_is_read_or_refused_with_little_work(name: str) -> None:
    for data in [*SEEDS[name], *(path.read_bytes() for path in sorted(KEPT.glob(f"{name}/*")))]:
        with suppress(Exception):  # what is imported on the way is not counted
            TARGETS[name](data)
        check(name, data)


@pytest.mark.parametrize("name", TARGETS)
def test_seeds_are_read(name: str) -> None:
    n_read = 0
    for seed in SEEDS[name]:
        with suppress(UnreadableFileError):
            TARGETS[name](seed)
            n_read += 1
    assert n_read
