"""`import primfit`: the names it promises, and nothing else."""

import doctest
import subprocess
import sys

import primfit
from primfit.app.engine import fit as engine
from primfit.fitting import recognize


def test_every_promised_name_is_there() -> None:
    for name in primfit.__all__:
        assert getattr(primfit, name) is not None


def test_the_same_engine_as_the_service() -> None:
    assert primfit.fit is engine.fit
    assert primfit.recognize is getattr(recognize, "recognize", recognize)


def test_the_example_in_the_docstring_runs() -> None:
    failures, tried = doctest.testmod(primfit)
    assert tried > 0
    assert failures == 0


def test_importing_it_loads_neither_the_service_nor_the_classifier() -> None:
    script = "import primfit, sys; print({'fastapi', 'sklearn', 'torch', 'typer'} & set(sys.modules))"
    found = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True).stdout
    assert found.strip() == "set()"
