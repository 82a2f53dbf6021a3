"""Points that are missing: dropped and counted, or refused by their place."""

import json

import numpy as np
import pytest

from primfit.app.engine.cut import cut_cloud
from primfit.app.readers import InvalidPointsError, Pick, UnreadableFileError, read, without_missing
from primfit.app.readers.missing import warnings_of
from tests.app.readers.written import e57, npy, pcd, records

POINTS = np.random.default_rng(8).normal(size=(12, 3))
HOLES = POINTS.copy()
HOLES[3], HOLES[5, 1], HOLES[7, 2], HOLES[9] = np.nan, np.inf, -np.inf, np.nan
KEPT = np.delete(POINTS, [3, 5, 7, 9], axis=0)


def _text(points: np.ndarray) -> bytes:
    return "\n".join(" ".join(map(repr, row)) for row in points.tolist()).encode()


def _obj(points: np.ndarray) -> bytes:
    return b"\n".join(b"v " + row for row in _text(points).split(b"\n"))


def _spreadsheet(points: np.ndarray) -> bytes:
    rows = (",".join(repr(cell) if np.isfinite(cell) else "" for cell in row) for row in points.tolist())
    return ("x,y,z\n" + "\n".join(rows)).encode()


WRITTEN = {
    "empty cells": _spreadsheet(HOLES),
    "empty cells and more columns": _spreadsheet(HOLES).replace(b"\n", b",7,\n").replace(b"z,7", b"z,k")
    + b",7,",
    "text": _text(HOLES),
    "npy": npy(HOLES),
    "organized npy": npy(HOLES.reshape(3, 4, 3)),
    "records": npy(records(HOLES)),
    "pcd": pcd(HOLES, "binary"),
    "obj": _obj(HOLES),
    "JSON of Python": json.dumps({"points": HOLES.tolist()}).encode(),
    "JSON with null": json.dumps({"points": np.where(np.isfinite(HOLES), HOLES, None).tolist()}).encode(),
}


@pytest.mark.parametrize("data", WRITTEN.values(), ids=WRITTEN)
def test_points_that_are_not_finite_are_dropped_and_counted(data: bytes) -> None:
    cloud = without_missing(read(data))
    np.testing.assert_array_equal(cloud.points, KEPT)
    assert cloud.dropped == {"not_finite": 4, "zero": 0}
    assert warnings_of(cloud)[-1] == ("Missing points were dropped: 4 with coordinates that are not finite.")
    assert without_missing(cloud) is cloud


def test_cells_between_tabs_may_be_empty() -> None:
    cloud = without_missing(read(b"x\ty\tz\n1\t\t3\n4\t5\t6\n7\t8\t\n\t8\t9\n1\t2\t3\t\n"))
    assert cloud.points.tolist() == [[4, 5, 6], [1, 2, 3]] and cloud.dropped["not_finite"] == 3


@pytest.mark.parametrize("data", WRITTEN.values(), ids=WRITTEN)
def test_or_refused_by_their_places(data: bytes) -> None:
    with pytest.raises(InvalidPointsError, match="8 coordinates are NaN or infinite") as caught:
        without_missing(read(data), "error")
    assert [error.field for error in caught.value.errors[:4]] == [
        "points[3][0]", "points[3][1]", "points[3][2]", "points[5][1]",
    ]  # fmt: skip


def test_zeros_are_missing_where_they_repeat() -> None:
    once, twice = POINTS.copy(), POINTS.copy()
    once[4], twice[[4, 8]] = 0.0, 0.0
    assert without_missing(read(npy(once))).points.tolist() == once.tolist()
    cloud = without_missing(read(npy(twice)))
    assert len(cloud.points) == 10 and cloud.dropped == {"not_finite": 0, "zero": 2}
    assert warnings_of(cloud) == ("Missing points were dropped: 2 exact zeros (0, 0, 0).",)
    assert len(without_missing(read(npy(twice)), "error").points) == 12


@pytest.mark.parametrize("lost", [np.full((5, 3), np.nan), np.zeros((5, 3))], ids=["nan", "zero"])
def test_a_cloud_of_missing_points_alone_is_refused(lost: np.ndarray) -> None:
    with pytest.raises(InvalidPointsError, match="no point is left: 5"):
        without_missing(read(npy(lost)))


def test_a_missing_point_needs_no_normal_and_no_label() -> None:
    normals = np.tile([0.0, 3.0, 4.0], (12, 1))
    normals[[3, 5, 7, 9]] = np.nan
    labels = np.where(np.isfinite(HOLES).all(axis=1), np.arange(12.0) % 2, np.nan)
    data = npy(records(HOLES, nx=normals[:, 0], ny=normals[:, 1], nz=normals[:, 2], label=labels))
    cloud = without_missing(read(data, pick=Pick("label")))
    assert cloud.normals is not None and cloud.labels is not None
    np.testing.assert_allclose(cloud.normals, np.tile([0.0, 0.6, 0.8], (8, 1)), rtol=1e-15)
    assert cloud.labels.tolist() == [0, 1, 0, 0, 0, 0, 0, 1]
    normals[0] = np.nan
    data = npy(records(HOLES, nx=normals[:, 0], ny=normals[:, 1], nz=normals[:, 2]))
    assert read(data).normals is None


def test_each_segment_counts_its_own() -> None:
    cut = cut_cloud(read(npy(records(HOLES, label=np.repeat([1, 2], 6))), pick=Pick("label")))
    assert cut is not None
    assert [without_missing(segment).dropped["not_finite"] for _, _, segment in cut] == [2, 2]


def test_json_is_strict_where_a_number_is_no_coordinate() -> None:
    for text in (b'{"points": [[1, 2, nan]]}', b'{"points": [[NaN, 2, 3]], "labels": [NaN]}',
                 b'{"points": [[NaN, 2, 3]', b'[' * 100_000 + b'NaN'):  # fmt: skip
        with pytest.raises(UnreadableFileError):
            read(text)


def test_zeros_of_an_e57_scan_are_missing_wherever_its_pose_moves_them() -> None:
    pose = (1.0, 0.0, 0.0, 0.0, 5.0, 6.0, 7.0)
    cloud = without_missing(read(e57(np.vstack([POINTS, np.zeros((3, 3))]), pose=pose)))
    np.testing.assert_allclose(cloud.points, POINTS + np.array([5.0, 6.0, 7.0]))
    assert cloud.dropped == {"not_finite": 0, "zero": 3}
