"""`import primfit`: the names it promises, and nothing else."""

import doctest
import subprocess
import sys

import pytest

import primfit
from primfit.app.engine import fit as engine
from primfit.fitting import recognize


def test_every_promised_name_is_there() -> None:
    for name in primfit.__all__:
        assert getattr(primfit, name) is not None


def test_dir_shows_what_is_public_and_nothing_else() -> None:
    primfit.fit([[0, 0, 0], [1, 0, 0], [0, 1, 0]], kinds=["plane"])
    assert dir(primfit) == sorted(set(primfit.__all__) - {"__version__"})


def test_the_same_engine_as_the_service() -> None:
    assert primfit.fit is engine.fit
    assert primfit.recognize is getattr(recognize, "recognize", recognize)


def test_the_example_in_the_docstring_runs() -> None:
    failures, tried = doctest.testmod(primfit)
    assert tried > 0
    assert failures == 0


SLOW = {"fastapi", "laspy", "multiprocessing", "pydantic", "scipy", "shapely", "sklearn", "torch", "typer"}
"""What takes long to import, or is for some uses only."""

SPHERE = """
directions = numpy.random.default_rng(0).normal(size=(500, 3))
primfit.fit(directions / numpy.linalg.norm(directions, axis=1)[:, None])
"""


@pytest.mark.parametrize(
    ("use", "slow"),
    [
        ("", SLOW | {"orjson"}),
        ("primfit.fit", SLOW),
        (SPHERE, SLOW - {"scipy"} | {"scipy.integrate", "scipy.optimize", "scipy.stats"}),
    ],
    ids=["primfit", "its fit", "a fit"],
)
def test_a_fresh_process_loads_what_it_needs(use: str, slow: set[str]) -> None:
    script = f"import numpy, primfit, sys\n{use}\nprint(*({slow} & sys.modules.keys()))"
    found = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True).stdout
    assert found.split() == []
