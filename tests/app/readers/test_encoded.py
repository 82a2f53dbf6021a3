"""Arrays in base64: the same numbers as in rows and in NPY, with all that may stand beside the points."""

import base64
import json
from typing import Any

import numpy as np
import pytest

from primfit.app.readers import Limits, Pick, TooLargeError, UnreadableFileError, read
from primfit.app.readers.encoded import DTYPES

POINTS = np.random.default_rng(8).normal(size=(40, 3)) * 100.0 + [1e6, -2e6, 3.0]


def _array(values: Any, kind: str = "<f8") -> dict[str, Any]:
    array = np.asarray(values, kind)
    encoded = base64.b64encode(array.tobytes()).decode()
    return {"dtype": array.dtype.name, "shape": list(array.shape), "base64": encoded}


def _body(**fields: Any) -> bytes:
    return json.dumps(fields).encode()


def test_base64_keeps_every_digit() -> None:
    cloud = read(_body(points=_array(POINTS)))
    np.testing.assert_array_equal(cloud.points, POINTS)
    np.testing.assert_array_equal(cloud.points, read(_body(points=POINTS.tolist())).points)
    assert (cloud.format, cloud.columns) == ("json", ("x", "y", "z"))
    assert cloud.points.flags.c_contiguous


@pytest.mark.parametrize("dtype", DTYPES)
def test_every_type_is_read(dtype: str) -> None:
    values = np.array([[1, 2, 3], [4, 5, 100]])
    points = read(_body(points=_array(values, f"<{np.dtype(dtype).str[1:]}"))).points
    np.testing.assert_array_equal(points, values)
    assert points.dtype == np.float64


@pytest.mark.parametrize("encoded", [False, True], ids=["rows", "base64"])
def test_what_stands_beside_the_points_is_read(encoded: bool) -> None:
    normals, weights = POINTS - POINTS.mean(axis=0), np.arange(1.0, 41.0)
    wrap = _array if encoded else np.ndarray.tolist
    cloud = read(_body(points=wrap(POINTS), normals=wrap(normals), weights=wrap(weights)))
    expected = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(cloud.normals, expected, rtol=1e-15)
    np.testing.assert_array_equal(cloud.weights, weights)
    assert cloud.columns == ("x", "y", "z", "normals", "weights")


@pytest.mark.parametrize(
    "labels",
    [list(range(40)), ["wall", "points"] * 20, _array(range(40), "<u2")],
    ids=["integers", "strings", "base64"],
)
def test_labels_are_read_when_asked_for(labels: Any) -> None:
    body = _body(points=POINTS.tolist(), labels=labels)
    for wanted in ("auto", "labels"):
        cloud = read(body, pick=Pick(wanted))
        assert cloud.labels is not None
        assert cloud.labels.tolist() == (list(range(40)) if isinstance(labels, dict) else labels)
        assert cloud.label_column == "labels"
        assert cloud.labels.dtype in (np.int64, object)
    assert read(body).labels is None
    with pytest.raises(UnreadableFileError, match="there is no such column"):
        read(body, pick=Pick("segment"))
    with pytest.raises(UnreadableFileError, match="there is no such column"):
        read(_body(points=POINTS.tolist()), pick=Pick("labels"))


def test_arrays_are_limited_like_files_and_rows_like_json() -> None:
    limits = Limits(points=40, json_points=10)
    assert len(read(_body(points=_array(POINTS)), limits).points) == 40
    for points, limit in ((_array(np.vstack([POINTS, POINTS])), 40), (POINTS.tolist(), 10)):
        with pytest.raises(TooLargeError, match=f"the limit is {limit}"):
            read(_body(points=points), limits)


def test_an_empty_array_is_read() -> None:
    assert read(_body(points=_array(np.empty((0, 3))))).points.shape == (0, 3)
