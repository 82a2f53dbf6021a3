"""The uncertainty as JSON, in the schema and on a terminal."""

import re
from io import StringIO
from pathlib import Path

import numpy as np
from rich.console import Console

from primfit import Cylinder
from primfit.app.cli.files import answer_file
from primfit.app.cli.render import render
from primfit.app.wire.schemas import FitAnswer


def write(folder: Path, degrees: float, sigma: float) -> str:
    rng, half = np.random.default_rng(0), np.radians(degrees) / 2
    pipe = Cylinder([0.0, 0.0, 1.0], [3.0, 2.0, 1.0], 50.0)
    points = pipe.surface(rng.uniform(-half, half, 400), rng.uniform(-60.0, 60.0, 400))
    path = folder / "pipe.csv"
    np.savetxt(path, points + sigma * rng.standard_normal(points.shape), delimiter=",")
    return str(path)


def shown(name: str, body: dict[str, object]) -> str:
    console = Console(width=200, file=StringIO())
    console.print(render(name, body))
    return console.file.getvalue()  # type: ignore[attr-defined]


def test_the_schema_has_every_field_of_an_answer(tmp_path: Path) -> None:
    body = answer_file(write(tmp_path, 40.0, 0.1), {"kinds": ["cylinder"]})[1]
    known = FitAnswer.model_validate(body).uncertainty
    assert known is not None and known.covariance is not None
    assert known.parameters[-1] == "radius" and len(known.covariance) == 7
    assert {warning.code for warning in known.warnings} == {"short_arc"}
    assert body["uncertainty"] == known.model_dump()


def test_a_terminal_shows_intervals_and_warnings(tmp_path: Path) -> None:
    text = shown("pipe.csv", answer_file(write(tmp_path, 40.0, 0.1), {"kinds": ["cylinder"]})[1])
    assert "with 95% intervals" in text and "across the axis" in text
    assert re.search(r"axis( +\S+){3} *\n +± \S+ degrees", text) and re.search(r"radius +49\.\d+ ± 0\.", text)
    assert "warning" in text and "degrees about the axis" in text


def test_an_end_that_is_open_is_said(tmp_path: Path) -> None:
    body = answer_file(write(tmp_path, 40.0, 0.1), {"kinds": ["cylinder"]})[1]
    body["uncertainty"]["intervals"]["radius"].update(high=None)
    assert re.search(r"radius +49\.\d+ \(at least 49\.\d+\)", shown("pipe.csv", body))


def test_no_uncertainty_is_null(tmp_path: Path) -> None:
    body = answer_file(write(tmp_path, 40.0, 0.1), {"kinds": ["cylinder"], "criterion": "minimum_zone"})[1]
    assert body["primitive"] is not None and body["uncertainty"] is None
    assert "direction within" not in shown("pipe.csv", body)
