"""Residuals as files, read back by other libraries: every digit, the order and the signs."""

import io
import pickle

import laspy
import numpy as np
import plyfile
import pytest

import primfit
from primfit.app.exports import FORMATS
from primfit.app.exports.residual_files import las_grid
from primfit.app.readers import read
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.names import UNITS, Unit

FILES = tuple(name for name in FORMATS if name.startswith("residuals_"))


def _cloud(offset: float = 0.0) -> tuple[Array, Array]:
    """A noisy sphere in whole thousandths, and how far the points were moved outwards; one is far away."""
    rng = np.random.default_rng(0)
    sphere = primfit.Sphere([offset, 0.0, 0.0], 10.0)
    feet = sphere.surface(rng.uniform(0.0, 6.28, 2000), rng.uniform(0.0, 3.14, 2000))
    moved = rng.normal(0.0, 0.01, 2000)
    moved[7] = 4.0
    return np.round(feet + moved[:, None] * sphere.gradient(feet), 3), moved


def test_residuals_are_signed_in_the_order_of_the_points_and_outliers_have_theirs() -> None:
    points, moved = _cloud()
    found = primfit.residuals(primfit.fit(points), points)
    np.testing.assert_allclose(found.distance, moved, atol=2e-3)
    assert found.distance[7] == pytest.approx(4.0, abs=2e-3)
    assert not found.inlier[7] and found.inlier.sum() > 1990


def test_a_single_point_has_a_residual() -> None:
    points, _ = _cloud()
    recognition = primfit.fit(points)
    every = primfit.residuals(recognition, points)
    for few in (points[7:8], np.repeat(points[7:8], 3, axis=0), points[:0]):
        found = primfit.residuals(recognition, few)
        np.testing.assert_array_equal(found.distance, np.full(len(few), every.distance[7]))
    with pytest.raises(primfit.InvalidPointCloudError, match="NaN"):
        primfit.residuals(recognition, [[0.0, 0.0, np.nan]])


@pytest.mark.parametrize("offset", [0.0, 5e6])
def test_files_hold_every_digit(offset: float) -> None:
    points, _ = _cloud(offset)
    recognition = primfit.fit(points)
    found = primfit.residuals(recognition, points)
    files = primfit.export(recognition, FILES, points)
    assert files == primfit.export(recognition, list(FILES), points.tolist())
    np.testing.assert_array_equal(np.load(io.BytesIO(files["residuals_npy"])), found.distance)

    table = np.loadtxt(io.BytesIO(files["residuals_csv"]), delimiter=",", skiprows=1)
    np.testing.assert_array_equal(table, np.column_stack([points, found.distance, found.inlier]))

    vertex = plyfile.PlyData.read(io.BytesIO(files["residuals_ply"]))["vertex"]
    np.testing.assert_array_equal(np.column_stack([vertex[name] for name in "xyz"]), points)
    np.testing.assert_array_equal(vertex["residual"], found.distance)
    np.testing.assert_array_equal(vertex["inlier"], found.inlier)
    red, blue = vertex["red"].astype(int), vertex["blue"].astype(int)
    far = np.abs(found.distance) > 0.005
    assert np.all((red > blue)[far] == (found.distance > 0.0)[far])

    las = laspy.read(io.BytesIO(files["residuals_las"]))
    np.testing.assert_array_equal(las["residual"], found.distance)
    np.testing.assert_array_equal(las["inlier"], found.inlier)
    np.testing.assert_allclose(las.xyz, points, rtol=1e-15, atol=4e-15)

    for name in FILES[1:]:
        np.testing.assert_allclose(read(memoryview(files[name])).points, points, rtol=1e-15, atol=4e-15)


@pytest.mark.parametrize("unit", UNITS)
def test_a_las_file_says_the_unit(unit: Unit) -> None:
    """Else the millimeters in it are read as meters."""
    points, _ = _cloud()
    cloud = read(memoryview(primfit.export(primfit.fit(points, unit=unit), "residuals_las")))
    assert (cloud.unit, cloud.unit_from, cloud.warnings) == (unit, "header", ())


@pytest.mark.parametrize("size", [1e-90, 1e-3, 1.0, 7e8, 1e90])
@pytest.mark.parametrize("offset", [0.0, 3.7, -4e6])
def test_a_las_grid_holds_all_points_to_the_billionth_of_their_extent(size: float, offset: float) -> None:
    points = size * (np.random.default_rng(1).uniform(-1.0, 1.0, (500, 3)) * [1.0, 0.3, 0.0] + offset)
    step, offsets = las_grid(points)
    whole = np.round((points - offsets) / step)
    assert np.abs(whole).max() < 2**31
    assert step <= 1e-8 * size
    np.testing.assert_allclose(
        whole * step + offsets, points, atol=0.51 * step + 1e-15 * np.abs(points).max()
    )


def test_points_that_are_missing_or_bad_are_named() -> None:
    points, _ = _cloud()
    left_behind = pickle.loads(pickle.dumps(primfit.fit(points)))
    for name in (*FILES, "form", "report"):
        with pytest.raises(primfit.InvalidOptionError, match="points are missing"):
            primfit.export(left_behind, name)
    with pytest.raises(primfit.InvalidPointCloudError, match="no point is left"):
        primfit.export(left_behind, "residuals_npy", np.full((5, 3), np.nan))
    flat = np.random.default_rng(0).uniform(-1.0, 1.0, (100, 3)) * [1.0, 1.0, 0.0]
    with pytest.raises(primfit.NothingToExportError, match="no primitive"):
        primfit.residuals(primfit.fit(flat, kinds=["torus"]), flat)
