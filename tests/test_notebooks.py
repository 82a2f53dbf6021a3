"""The notebooks of docs/notebooks run, print what stands in them, and find what is true of the samples."""

from ast import literal_eval
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.paths import DOCS

NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))
WIDGET = "application/vnd.jupyter.widget-view+json"

ASKED = {
    "first-fit": "answer.primitive.kind, answer.primitive.radius, radius.standard_deviation",
    "how-sure": "answer.primitive.kind, arc.primitive.kind, radius.low, radius.high, corner.status",
    "whole-scan": "[(s.recognition.primitive.kind, s.recognition.to_dict()['primitive']) for s in segments]",
}
"""What is asked of each notebook after its last cell."""


@pytest.fixture(scope="module", params=NOTEBOOKS, ids=lambda path: path.stem)
def ran(request: pytest.FixtureRequest) -> tuple[Path, Any]:
    """A notebook, and the same with all outputs and what was asked of it."""
    for needed in ("k3d", "ipykernel", "nbclient"):
        pytest.importorskip(needed, reason=f"needs {needed}: pip install 'primfit[dev]'")
    from docs.notebooks.run import run

    return request.param, run(request.param, ASKED[request.param.stem])


def test_it_prints_what_stands_there(ran: tuple[Path, Any]) -> None:
    import nbformat

    from docs.notebooks.run import printed

    path, notebook = ran
    *now, asked = printed(notebook)
    assert asked == ""
    assert now == printed(nbformat.read(path, as_version=4)), "run `make notebooks`"
    assert len(list(filter(None, now))) >= 3


def test_it_shows_a_picture(ran: tuple[Path, Any]) -> None:
    shown = [cell for cell in ran[1].cells if ".show()" in cell.source and cell.cell_type == "code"]
    assert shown
    for cell in shown:
        assert [WIDGET in output.data for output in cell.outputs] == [True]


def test_what_it_finds_is_true(ran: tuple[Path, Any]) -> None:
    path, notebook = ran
    (output,) = notebook.cells[-1].outputs
    TRUE[path.stem](literal_eval(output.data["text/plain"]))


def _first_fit(found: Any) -> None:
    kind, radius, deviation = found
    assert kind == "cylinder"
    assert abs(radius - 57.15) < 2.0 * deviation < 0.1


def _how_sure(found: Any) -> None:
    pipe, arc, low, high, corner = found
    assert (pipe, arc, corner) == ("cylinder", "cylinder", "no_fit")
    assert low < 80.0 < high


def _whole_scan(found: Any) -> None:
    kinds, parameters = zip(*found, strict=True)
    assert kinds == ("plane", "cylinder", "sphere", "cone")
    _, pipe, vessel, hopper = parameters
    assert pipe["radius"] == pytest.approx(0.1095, abs=5e-4)
    assert vessel["radius"] == pytest.approx(0.6, abs=5e-4)
    assert hopper["half_angle"] == pytest.approx(np.radians(25.0), abs=5e-3)


TRUE = {"first-fit": _first_fit, "how-sure": _how_sure, "whole-scan": _whole_scan}
"""samples/README.md says what is true."""
