"""What an ambiguous answer says, through REST, the command line, exports and Python: as JSON and in words."""

import csv
import io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import primfit
from primfit.app.cli.commands import app
from primfit.app.readers import Limits
from primfit.app.wire.schemas import FitAnswer
from primfit.app.workers import jobs
from primfit.fitting.answer.result import Recognition
from primfit.fitting.primitives import parameters
from tests.app.serving import EXAMPLES, Service
from tests.fitting.by_hand import CORRELATED, SMOOTH, ambiguous, cloud_of

CSV = EXAMPLES / "cylinder.csv"
BESIDE = {"error", "extents", "uncertainty", "evidence"}


@pytest.fixture(scope="module")
def recognition() -> Recognition:
    return ambiguous()


@pytest.fixture
def answered(recognition: Recognition, monkeypatch: pytest.MonkeyPatch) -> Recognition:
    """What every fit of this process gives."""
    monkeypatch.setattr("primfit.app.engine.answer.fit_prepared", lambda cloud, options: recognition)
    return recognition


def _posted(body: bytes, media_type: str = "application/json") -> dict[str, Any]:
    """The answer of a worker to `POST /fit`."""
    reply = jobs.run(jobs.FitJob("id", body, media_type, media_type, None, [], Limits()))
    assert reply.status == 200, reply.content
    return json.loads(reply.content)  # type: ignore[no-any-return]


def _run(*args: object) -> Any:
    return CliRunner().invoke(app, [str(arg) for arg in args])


def test_an_alternative_is_the_flat_primitive_with_what_stands_beside_it(answered: Recognition) -> None:
    body = _posted((EXAMPLES / "request.json").read_bytes())
    assert body["status"] == "ambiguous"
    for shown, other in zip(body["alternatives"], answered.alternatives, strict=True):
        assert shown == parameters(other.primitive) | {name: shown[name] for name in BESIDE}
        assert shown["error"]["inlier_rms"] == other.error.inlier_rms
        assert shown["extents"]["kind"] == shown["kind"]
        assert shown["uncertainty"]["intervals"].keys() == other.uncertainty.intervals.keys()  # type: ignore[union-attr]
    assert [shown["evidence"] for shown in body["alternatives"]] == [-1.0, -2.0, -3.0, -4.0]
    assert body["attempts"][0]["evidence"] == 0.0
    assert body["noise"]["correlated"] == {"size": CORRELATED.size, "range": CORRELATED.range}
    assert body["noise"]["smooth"] == {"size": SMOOTH.size, "range": SMOOTH.range}


def test_the_schema_has_every_field(answered: Recognition) -> None:
    body = _posted(CSV.read_bytes(), "text/csv")
    FitAnswer.model_validate(body, strict=True)
    # What is left out is `include` of the receipt, which stands there where a part was not asked for.
    assert FitAnswer.model_validate(body).model_dump(exclude_unset=True) == body


def test_an_alternative_may_know_neither_extents_nor_uncertainty(recognition: Recognition) -> None:
    bare = [
        replace(other, extents=None, uncertainty=None, evidence=None) for other in recognition.alternatives
    ]
    values = replace(recognition, alternatives=tuple(bare)).to_dict()
    shown = FitAnswer.model_validate(values | {"receipt": _posted(CSV.read_bytes(), "text/csv")["receipt"]})
    assert all(other.extents is other.uncertainty is other.evidence is None for other in shown.alternatives)


def test_the_command_line_gives_the_body_and_says_the_same_in_words(answered: Recognition) -> None:
    result = _run("fit", "--json", CSV)
    assert result.exit_code == 3
    assert json.loads(result.stdout) == _posted(CSV.read_bytes(), "text/csv")
    shown = _run("fit", CSV).stdout
    for other in answered.alternatives:
        assert f"{other.primitive.kind}, with 95% intervals" in shown
    assert shown.count("\ninliers ") == shown.count("\nform error ") == 5
    assert "neighboring points share a deviation of 0.00400 over 0.350" in shown
    assert "evidence" in shown


def test_a_batch_writes_the_alternatives_too(answered: Recognition, tmp_path: Path) -> None:
    assert _run("batch", CSV, "--out", tmp_path, "--workers", "1").exit_code == 0
    body = json.loads((tmp_path / "cylinder.json").read_bytes())
    assert body == _posted(CSV.read_bytes(), "text/csv")


def test_a_report_shows_each_alternative_with_its_numbers(recognition: Recognition) -> None:
    page = primfit.export(recognition, "report", cloud_of("cylinder"), unit="mm").decode()
    for other in recognition.alternatives:
        section = page.partition(f"<h2>Alternative: {other.primitive.kind}</h2>")[2].partition("</section>")[
            0
        ]
        assert "95% interval" in section and "rms of inliers" in section
        assert f"<h2>Extents of the {other.primitive.kind}</h2>" in page
    assert page.count("rms of inliers</th>") == 5
    assert ">0.4000 mm over 60.00 mm</td>" in page
    assert '<th class="number" scope="col">evidence</th>' in page


def test_a_row_has_columns_for_the_deviations(recognition: Recognition) -> None:
    points = cloud_of("cylinder")
    (row,) = csv.DictReader(io.StringIO(primfit.export(recognition, "csv", points).decode()))
    assert float(row["inlier_rms"]) == recognition.error.inlier_rms  # type: ignore[union-attr]
    assert (row["noise_correlated_size"], row["noise_smooth_range"]) == ("0.004", "60.0")
    assert recognition.noise
    without = replace(recognition, noise=replace(recognition.noise, correlated=None, smooth=None))
    (empty,) = csv.DictReader(io.StringIO(primfit.export(without, "csv", points).decode()))
    assert empty.keys() == row.keys() and empty["noise_correlated_size"] == empty["noise_smooth_range"] == ""


def test_every_way_in_gives_the_new_numbers(service: Service) -> None:
    points = np.loadtxt(CSV, delimiter=",", skiprows=2)
    expected = primfit.fit(points).to_dict()
    posted = service.post(CSV.read_bytes(), "text/csv").json()
    printed = json.loads(_run("fit", "--json", CSV).stdout)
    for body in (posted, printed):
        assert body["error"]["inlier_rms"] == expected["error"]["inlier_rms"] > 0.0
        assert body["noise"] == expected["noise"] and body["noise"].keys() >= {"correlated", "smooth"}
        assert [attempt["evidence"] for attempt in body["attempts"]] == [
            attempt["evidence"] for attempt in expected["attempts"]
        ]
