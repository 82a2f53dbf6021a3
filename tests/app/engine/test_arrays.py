"""Clouds of other libraries give the answer of their arrays; what is not installed is skipped."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import primfit
from primfit.app.readers.cloud import unit_normals
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError
from tests.fitting.clouds import EXAMPLES, noisy

CYLINDER = EXAMPLES["cylinder"]
POINTS = noisy(CYLINDER, 300, 0.01)
NORMALS = unit_normals(CYLINDER.gradient(POINTS))
ROWS = np.hstack([POINTS, CYLINDER.gradient(POINTS)])
PLAIN = primfit.fit(POINTS).to_json()
WITH_NORMALS = primfit.fit(POINTS, normals=NORMALS).to_json()


class Arrayish:
    """What offers NumPy an array, as many libraries do."""

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return POINTS.astype(dtype or float)


def records(names: str) -> np.ndarray:
    return np.rec.fromarrays(ROWS[:, : len(names.split())].T, names=names.replace(" ", ","))


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (POINTS.tolist(), PLAIN),
        (Arrayish(), PLAIN),
        (records("x y z"), PLAIN),
        (records("X y z normal_x normal_y normal_z"), WITH_NORMALS),
    ],
    ids=["lists", "an array by request", "records", "records with normals"],
)
def test_what_numpy_reads(given: Any, expected: str) -> None:
    assert primfit.fit(given).to_json() == expected


@pytest.mark.parametrize(
    "given",
    [
        np.hstack([POINTS, np.full((300, 1), 0.5)]),
        np.column_stack([np.arange(300), POINTS]),
        np.column_stack([np.arange(7, 307), POINTS, POINTS[:, 0]]),
        POINTS.reshape(15, 20, 3),
        np.dstack([POINTS.reshape(15, 20, 3), np.ones((15, 20))]),
    ],
    ids=["intensity", "index", "index and intensity", "organized", "organized with intensity"],
)
def test_wider_and_organized_arrays_by_the_rules_of_files(given: np.ndarray) -> None:
    found = primfit.fit(given)
    assert replace(found, warnings=()).to_json() == PLAIN
    np.testing.assert_array_equal(found.points, POINTS)


def test_a_wider_array_is_told_which_columns_were_taken(tmp_path: Path) -> None:
    for whole, taken in (
        (np.column_stack([POINTS, np.ones(300)]), "The 4 columns have no names: columns 1, 2, 3"),
        (np.column_stack([np.arange(300), POINTS]), "The 4 columns have no names: columns 2, 3, 4"),
    ):
        np.savetxt(tmp_path / "cloud.txt", whole)
        assert primfit.fit(whole).warnings == (f"{taken} are taken for x, y and z.",)
        assert primfit.fit(whole).warnings == primfit.fit(tmp_path / "cloud.txt").warnings
        (segment,) = primfit.fit_segments(whole, ["a"] * 300)
        assert segment.recognition is not None
        assert segment.recognition.warnings == primfit.fit(whole).warnings
    assert primfit.fit(POINTS).warnings == primfit.fit(whole, columns=[2, 3, 4]).warnings == ()


def test_a_first_column_that_may_be_x_or_something_else_is_asked_for() -> None:
    whole = np.column_stack([np.arange(300) // 2, POINTS])
    with pytest.raises(InvalidOptionError, match=r"columns: 4 columns without names: .* 1,2,3 or 2,3,4"):
        primfit.fit(whole)
    assert primfit.fit(whole, columns=np.array([2, 3, 4])).to_json() == PLAIN


@pytest.mark.parametrize(
    "given",
    [POINTS.T, np.vstack([POINTS.T, np.ones(300)]), POINTS.T.reshape(3, 15, 20)],
    ids=["(3, N)", "(4, N)", "(3, H, W)"],
)
def test_a_transposed_array_is_refused(given: np.ndarray) -> None:
    with pytest.raises(InvalidPointCloudError, match=r"points have shape .*; \(N, 3\) is needed"):
        primfit.fit(given)


def test_organized_records_are_taken_row_by_row() -> None:
    found = primfit.fit(records("x y z").reshape(15, 20))
    assert found.to_json() == PLAIN
    several = np.zeros(300, [("x", "f8", 3), ("y", "f8"), ("z", "f8")])
    with pytest.raises(InvalidPointCloudError, match="several numbers a point"):
        primfit.fit(several)


def test_pandas_by_the_names_of_the_columns() -> None:
    pandas = pytest.importorskip("pandas", reason="needs pandas")
    names = ["nz", "z", "x", "y", "nx", "ny"]
    table = pandas.DataFrame(ROWS[:, [5, 2, 0, 1, 3, 4]], columns=names).assign(name="part")
    assert primfit.fit(table).to_json() == WITH_NORMALS
    assert primfit.fit(table[["z", "x", "y", "name"]]).to_json() == PLAIN
    assert primfit.fit(pandas.DataFrame(POINTS)).to_json() == PLAIN
    with pytest.raises(InvalidPointCloudError, match="points: no column named x, y, z among a, b, c"):
        primfit.fit(pandas.DataFrame(POINTS, columns=["a", "b", "c"]))
    with pytest.raises(InvalidPointCloudError, match=r"points\['x'\]: Series is not an array of numbers"):
        primfit.fit(pandas.DataFrame({"x": ["a"] * 9, "y": 0.0, "z": 0.0}))
    (segment,) = primfit.fit_segments(table, pandas.Series(["a"] * 300))
    assert segment.recognition is not None and segment.recognition.to_json() == WITH_NORMALS


def test_trimesh_gives_its_vertices() -> None:
    trimesh = pytest.importorskip("trimesh")
    assert primfit.fit(trimesh.PointCloud(POINTS)).to_json() == PLAIN
    mesh = trimesh.Trimesh(POINTS, np.arange(300).reshape(100, 3), process=False)
    assert primfit.fit(mesh).to_json() == PLAIN
    assert primfit.fit(mesh, normals=NORMALS).to_json() == WITH_NORMALS


def test_open3d_with_its_normals() -> None:
    open3d = pytest.importorskip("open3d", reason="needs open3d")
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(POINTS))
    assert primfit.fit(cloud).to_json() == PLAIN
    cloud.normals = open3d.utility.Vector3dVector(ROWS[:, 3:])
    assert primfit.fit(cloud).to_json() == WITH_NORMALS
    (segment,) = primfit.fit_segments(cloud, np.zeros(300, int))
    assert segment.recognition is not None and segment.recognition.to_json() == WITH_NORMALS
    tensors = open3d.t.geometry.PointCloud.from_legacy(cloud, open3d.core.float64)
    assert primfit.fit(tensors).to_json() == WITH_NORMALS
    del tensors.point["normals"]
    assert primfit.fit(tensors).to_json() == PLAIN
    mesh = open3d.geometry.TriangleMesh(
        cloud.points, open3d.utility.Vector3iVector(np.arange(300).reshape(100, 3))
    )
    mesh.compute_vertex_normals()
    assert primfit.fit(mesh).to_json() == PLAIN
    assert (
        primfit.fit(open3d.t.geometry.TriangleMesh.from_legacy(mesh, open3d.core.float64)).to_json() == PLAIN
    )
    with pytest.raises(InvalidPointCloudError, match="points: PointCloud is not an array of numbers"):
        primfit.fit(open3d.t.geometry.PointCloud())


@pytest.mark.parametrize(
    ("given", "kind"),
    [
        ({"x": [1.0]}, "dict"),
        (None, "NoneType"),
        (3.0, "float"),
        (object(), "object"),
        (POINTS + 1j, "ndarray"),
        (POINTS.astype(str), "ndarray"),
        (POINTS.astype("M8[s]"), "ndarray"),
        (CYLINDER, "Cylinder"),
        ((row for row in POINTS), "generator"),
    ],
    ids=lambda value: value if isinstance(value, str) else "given",
)
def test_what_is_no_cloud_is_named(given: Any, kind: str) -> None:
    with pytest.raises(
        InvalidPointCloudError, match=f"^points: {kind} is not an array of numbers; give"
    ) as caught:
        primfit.fit(given)
    assert caught.value.field == "points"


def test_masked_coordinates_are_missing() -> None:
    masked = np.ma.array(POINTS, mask=np.zeros_like(POINTS, bool))
    assert primfit.fit(masked).to_json() == PLAIN
    masked[3, 1] = np.ma.masked
    others = primfit.fit(np.delete(POINTS, 3, axis=0)).to_dict()
    assert primfit.fit(masked).to_dict()["primitive"] == others["primitive"]
    assert primfit.fit(masked).warnings == (
        "Missing points were dropped: 1 with coordinates that are not finite.",
    )
    with pytest.raises(InvalidPointCloudError, match="1 coordinates are NaN or infinite") as caught:
        primfit.fit(masked, missing="error")
    assert caught.value.field == "points[3][1]"


def test_a_file_is_fitted_by_its_name(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "cloud.csv", POINTS, "%.17g", delimiter=",")
    for name in (tmp_path / "cloud.csv", str(tmp_path / "cloud.csv")):
        assert primfit.fit(name).to_json() == PLAIN
    with pytest.raises(FileNotFoundError):
        primfit.fit("no such file")


def test_other_fields_are_named_too() -> None:
    with pytest.raises(InvalidPointCloudError, match=r"^weights: dict is not an array of numbers$") as caught:
        primfit.fit(POINTS, weights={})
    assert caught.value.field == "weights"


def test_no_other_library_is_imported() -> None:
    script = (
        "import sys, numpy as np, primfit\n"
        "points = np.random.default_rng(0).normal(size=(50, 3))\n"
        "print(primfit.fit(points, kinds=['sphere']))\n"
        "print(sorted({'open3d', 'pandas', 'sklearn', 'torch', 'trimesh'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "[]"
