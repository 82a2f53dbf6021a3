"""A client generated from the OpenAPI document of version 0.1 still sends requests and reads answers."""

import gzip
import importlib
import io
import json
import zipfile
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import httpx
import pytest

from primfit.app.engine.answer import answer, to_json
from primfit.app.readers import read
from primfit.fitting.primitives import parameters
from tests.app.generating import generated_client
from tests.app.serving import Service
from tests.fitting.by_hand import ambiguous
from tests.paths import EXAMPLES, ROOT

DOCUMENT = gzip.decompress((ROOT / "tests" / "clients" / "openapi-0.1.json.gz").read_bytes())
NAME = "primfit_client_0_1"
SMALL = json.loads((EXAMPLES / "request.json").read_bytes())
CSV = (EXAMPLES / "cylinder.csv").read_bytes()


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModuleType]:
    """The generated package."""
    with generated_client(DOCUMENT, NAME, tmp_path_factory.mktemp("client")) as package:
        yield package


def _part(name: str) -> ModuleType:
    return importlib.import_module(f"{NAME}.{name}")


def _connected(generated: ModuleType, service: Service) -> Any:
    return generated.Client(base_url=f"http://127.0.0.1:{service.port}", timeout=60)


def test_it_sends_options_and_a_guess_and_reads_the_answer(generated: ModuleType, service: Service) -> None:
    models, fit = _part("models"), _part("api.fitting.fit")
    with _connected(generated, service) as client:
        first = fit.sync(client=client, body=models.FitRequest(points=SMALL["points"]))
        assert isinstance(first.primitive, models.Cylinder)
        options = models.FitOptions(
            kinds=[models.KindName.CYLINDER], max_error=0.5, seed=3, initial_guess=first.primitive
        )
        found = fit.sync(client=client, body=models.FitRequest(points=SMALL["points"], options=options))
    assert isinstance(found, models.FitAnswer) and found.status == "fitted"
    assert found.primitive.radius == pytest.approx(first.primitive.radius, rel=1e-6)
    assert found.receipt.options.max_error == 0.5 and found.receipt.options.seed == 3
    assert found.error.rms > 0.0 and found.noise.scale > 0.0 and found.attempts[0].error.rms > 0.0


def test_it_sends_files_and_reads_lines_and_problems(generated: ModuleType, service: Service) -> None:
    models, types = _part("models"), _part("types")
    with _connected(generated, service) as client:
        upload = models.BatchUpload(file=[types.File(io.BytesIO(CSV), "cylinder.csv", "text/csv")])
        lines = _part("api.fitting.fit_batch").sync_detailed(client=client, body=upload).content.splitlines()
        few = _part("api.fitting.fit").sync(client=client, body=models.FitRequest(points=[[1.0, 2.0, 3.0]]))
        told = _part("api.service.capabilities").sync(client=client)
    line = models.BatchAnswer.from_dict(json.loads(lines[0]))
    assert isinstance(line.answer.primitive, models.Cylinder)
    assert isinstance(few, models.Problem) and few.errors[0].field == "points"
    assert [option.name for option in told.options][:4] == ["kinds", "classifier", "criterion", "max_error"]


def test_it_gets_the_files_of_an_export(generated: ModuleType, service: Service) -> None:
    """Its unit stood with the options of the export, and is one of the fit now."""
    models, types = _part("models"), _part("types")
    wanted = models.FitExportArtifactsItem
    with _connected(generated, service) as client:
        response = _part("api.fitting.fit_export").sync_detailed(
            client=client,
            body=models.FitUpload(file=types.File(io.BytesIO(CSV), "cylinder.csv", "text/csv")),
            artifacts=[wanted.STEP, wanted.CSV],
            unit=models.FitExportUnit.MM,
            chord_error=0.01,
            kinds=[models.KindName.CYLINDER],
        )
    assert response.status_code == 200
    with zipfile.ZipFile(io.BytesIO(response.content)) as archive:
        assert archive.namelist() == ["answer.json", "primitive.step", "primitive.csv"]
        answer = models.FitAnswer.from_dict(json.loads(archive.read("answer.json")))
        assert b"SI_UNIT(.MILLI.,.METRE.)" in archive.read("primitive.step")
    assert isinstance(answer.primitive, models.Cylinder)


@pytest.mark.parametrize("first", ["cylinder", "plane"])
def test_it_reads_the_alternatives_of_an_ambiguous_answer(generated: ModuleType, first: str) -> None:
    models, fit = _part("models"), _part("api.fitting.fit")
    recognition = ambiguous(first)
    body = to_json(answer(recognition, read(CSV), {"tolerance": 0.1}))
    transport = httpx.MockTransport(lambda request: httpx.Response(200, content=body))
    with generated.Client(base_url="http://primfit", httpx_args={"transport": transport}) as client:
        found = fit.sync(client=client, body=models.FitRequest(points=SMALL["points"]))
    assert isinstance(found, models.FitAnswer) and found.status == "ambiguous"
    assert len(found.alternatives) == 4
    for read_back, other in zip(found.alternatives, recognition.alternatives, strict=True):
        assert type(read_back).__name__ == type(other.primitive).__name__
        assert read_back.to_dict() == parameters(other.primitive)
    assert found.primitive.to_dict() == parameters(recognition.primitive)  # type: ignore[arg-type]
    assert found.noise.scale == recognition.noise.scale  # type: ignore[union-attr]
