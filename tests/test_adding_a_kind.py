"""docs/adding-a-kind.patch: applied to a copy, an ellipsoid is fitted over HTTP, by command, into STEP."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.app.serving import Service, running
from tests.installing import copy_sources
from tests.paths import DOCS

PATCH = DOCS / "adding-a-kind.patch"
MOST_FILES, MOST_OLD = 12, 3
RADII = np.array([5.0, 3.0, 2.0])
CENTER = np.array([10.0, -4.0, 7.0])

pytestmark = pytest.mark.slow


def test_the_patch_touches_few_files_and_hardly_any_that_were_there() -> None:
    text = PATCH.read_text()
    assert text.count("\ndiff --git ") + text.startswith("diff --git ") <= MOST_FILES
    assert text.count("\ndiff --git ") + 1 - text.count("\nnew file mode ") <= MOST_OLD


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A copy of the sources with the patch, compiled, which processes that are started here import."""
    copy = copy_sources(tmp_path_factory.mktemp("kind") / "copy")
    subprocess.run(["git", "apply", str(PATCH)], cwd=copy, check=True)
    subprocess.run([sys.executable, "setup.py", "-q", "build_ext", "--inplace"], cwd=copy, check=True)
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = str(copy / "src")
    yield copy
    if before is None:
        del os.environ["PYTHONPATH"]
    else:
        os.environ["PYTHONPATH"] = before


@pytest.fixture(scope="module")
def service(copy: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with running(tmp_path_factory.mktemp("bodies"), code=copy, workers=1) as started:
        yield started


@pytest.fixture(scope="module")
def cloud(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Points of an ellipsoid, its largest radius along y and its smallest along x, with noise of 0.005."""
    rng = np.random.default_rng(4)
    directions = rng.normal(size=(1500, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    points = CENTER + directions * RADII[[2, 0, 1]] + 0.005 * rng.normal(size=(1500, 3))
    file = tmp_path_factory.mktemp("cloud") / "ellipsoid.csv"
    np.savetxt(file, points, delimiter=",", header="x,y,z", comments="")
    return file


def check(answer: dict[str, Any]) -> None:
    primitive = answer["primitive"]
    assert (answer["status"], primitive["kind"]) == ("fitted", "ellipsoid"), answer["message"]
    radii = [primitive[f"{place}_radius"] for place in ("first", "second", "third")]
    np.testing.assert_allclose(radii, RADII, atol=2e-3)
    np.testing.assert_allclose(primitive["center"], CENTER, atol=2e-3)
    assert abs(primitive["first_axis"][1]) > 0.99999 and abs(primitive["second_axis"][2]) > 0.99999
    assert answer["extents"]["kind"] == "ellipsoid" and answer["extents"]["coverage"] > 0.9
    interval = answer["uncertainty"]["intervals"]["first_radius"]
    assert interval["low"] < 5.0 < interval["high"]
    (attempt,) = (each for each in answer["attempts"] if each["kind"] == "ellipsoid")
    assert attempt["probability"] == pytest.approx(1.0 / 6.0), "the classifiers have not learned it"


def test_over_http(service: Service, cloud: Path) -> None:
    response = service.client.post("/fit", content=cloud.read_bytes(), headers={"Content-Type": "text/csv"})
    assert response.status_code == 200, response.text
    check(response.json())
    document = service.client.get("/openapi.json").json()
    assert "third_radius" in document["components"]["schemas"]["Ellipsoid"]["properties"]


def test_on_the_command_line(copy: Path, cloud: Path) -> None:
    command = [sys.executable, "-m", "primfit", "fit", "--json", str(cloud)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=copy)
    check(json.loads(done.stdout))


def test_into_a_step_file(copy: Path, cloud: Path, tmp_path: Path) -> None:
    file = tmp_path / "ellipsoid.step"
    command = [sys.executable, "-m", "primfit", "fit", "--unit", "mm", "--step", str(file), str(cloud)]
    subprocess.run(command, capture_output=True, check=True, cwd=copy)
    text = file.read_text()
    assert text.count("RATIONAL_B_SPLINE_SURFACE") == 1 and "CLOSED_SHELL" in text
    pytest.importorskip("OCP", reason="needs the extra cad")
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.STEPControl import STEPControl_Reader

    reader = STEPControl_Reader()
    reader.ReadFile(str(file))
    reader.TransferRoots()
    assert BRepCheck_Analyzer(reader.OneShape()).IsValid()


OTHERS = """
import numpy as np, primfit

rng, kinds = np.random.default_rng(6), []
u, v = rng.uniform(0.0, 4.0, 600), rng.uniform(0.5, 2.0, 600)
for given in (
    primfit.Plane([0.0, 0.6, 0.8], [1.0, 2.0, 3.0]),
    primfit.Sphere([1.0, 2.0, 3.0], 2.0),
    primfit.Cylinder([0.0, 0.6, 0.8], [1.0, 2.0, 3.0], 1.0),
    primfit.Cone([1.0, 2.0, 3.0], [0.0, 0.6, 0.8], 0.4),
    primfit.Torus([1.0, 2.0, 3.0], [0.0, 0.6, 0.8], 3.0, 1.0),
):
    found = primfit.fit(given.surface(u, v) + 0.005 * rng.normal(size=(600, 3)))
    print(found.status, given.kind == found.primitive.kind)
"""


def test_the_other_kinds_are_still_found(copy: Path) -> None:
    done = subprocess.run([sys.executable, "-c", OTHERS], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["fitted", "True"] * 5


def test_its_own_tests_hold(copy: Path) -> None:
    """They are part of the patch; the copy has no others."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/fitting/primitives"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=copy)
    assert done.returncode == 0, done.stdout
