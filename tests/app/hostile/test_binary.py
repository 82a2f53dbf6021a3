"""Binary files that lie, never end, unpack without end or hide code: refused within a second and 64 MB."""

import io

import numpy as np
import pytest

from tests.app.hostile import measure
from tests.app.hostile.binary import CASES, Canary
from tests.app.hostile.refusals import REFUSALS, refusal
from tests.app.readers.written import npy


@pytest.mark.parametrize(("name", "data"), CASES.items(), ids=CASES)
def test_hostile_input_is_refused_quickly_and_the_field_named(name: str, data: bytes) -> None:
    assert refusal(data) == REFUSALS[name]
    assert not Canary.path.exists()


def test_the_canary_runs_where_a_pickle_is_loaded() -> None:
    try:
        np.load(io.BytesIO(CASES["npy of objects"]), allow_pickle=True)
        assert Canary.path.exists()
    finally:
        Canary.path.unlink(missing_ok=True)


def test_what_a_large_file_costs_is_seen() -> None:
    found = measure.ask(npy(np.zeros((4_000_000, 3))))
    assert found["error"] == "nothing"
    assert found["bytes"] > measure.MEMORY
