"""The sample scans are those that samples/make.py writes, and primfit finds what samples/README.md says."""

from typing import Any

import numpy as np
import pytest

import primfit
from primfit.app.readers import read
from samples.make import samples
from tests.paths import ROOT

FOLDER = ROOT / "samples"


def points_of(name: str) -> Any:
    return read((FOLDER / name).read_bytes()).points


def test_the_folder_holds_what_the_script_writes_and_little_of_it() -> None:
    made = samples()
    names = {path.name for path in FOLDER.iterdir()} - {"README.md", "make.py", "__pycache__"}
    assert names == set(made)
    assert sum(len(content) for content in made.values()) < 1_000_000


@pytest.mark.parametrize("name", samples())
def test_a_file_is_written_the_same_again(name: str) -> None:
    again = read(samples()[name]).points
    assert again == pytest.approx(points_of(name), abs=1e-6 * np.ptp(again, axis=0).max())


@pytest.mark.parametrize(
    ("name", "kind", "parameter", "value"),
    [
        ("pipe.ply", "cylinder", "radius", 57.15),
        ("tank-end.xyz", "sphere", "radius", 1.25),
        ("nozzle.pcd", "cone", "half_angle", np.radians(12.0)),
        ("handwheel.xyz", "torus", "minor_radius", 12.0),
    ],
)
def test_a_sample_is_recognized(name: str, kind: str, parameter: str, value: float) -> None:
    answer = primfit.fit(points_of(name))
    assert (answer.status, answer.primitive.kind) == ("fitted", kind)
    interval = answer.uncertainty.intervals[parameter]
    # The truth is inside twice the 95% interval: samples are fixed, so this either holds or does not.
    half = interval.high - interval.low
    assert abs(getattr(answer.primitive, parameter) - value) < half


def test_the_floor_is_a_plane_with_a_hole() -> None:
    answer = primfit.fit(points_of("floor.csv"))
    assert (answer.status, answer.primitive.kind) == ("fitted", "plane")
    assert [len(piece) for piece in answer.extents.concave_outline] == [2]
    assert answer.primitive.normal[0] / answer.primitive.normal[2] == pytest.approx(0.01, abs=1e-3)


def test_the_short_arc_is_ambiguous_and_the_corner_is_none() -> None:
    arc = primfit.fit(points_of("short-arc.csv"))
    assert arc.status == "ambiguous"
    assert {arc.primitive.kind, *(other.primitive.kind for other in arc.alternatives)} == {
        "cylinder",
        "plane",
    }
    assert primfit.fit(points_of("corner.xyz")).status == "no_fit"


@pytest.mark.parametrize(
    ("name", "status", "tolerance", "kind"),
    [("plate.csv", "ambiguous", 3.0, "plane"), ("oval-pipe.csv", "no_fit", 1.0, "cylinder")],
)
def test_a_tolerance_settles_what_deviates(name: str, status: str, tolerance: float, kind: str) -> None:
    points = points_of(name)
    assert primfit.fit(points).status == status
    answer = primfit.fit(points, tolerance=tolerance)
    assert (answer.status, answer.primitive.kind) == ("fitted", kind)
