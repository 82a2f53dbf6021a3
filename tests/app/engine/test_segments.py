"""The segments of a cloud, in Python: the numbers of `fit`, in the order of the labels."""

import numpy as np
import pytest

import primfit
from primfit.app.engine.answer import answer
from primfit.app.engine.segments import cut, cut_cloud, part
from primfit.app.readers.cloud import Cloud
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError

RNG = np.random.default_rng(8)
NORMALS = RNG.normal(size=(300, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)
SPHERES = np.vstack([NORMALS, 2 * NORMALS + 5, [[0, 0, 0], [1, 1, 1]]])
SPHERE_NORMALS = np.vstack([NORMALS, NORMALS, [[0, 0, 1]] * 2])
LABELS = np.repeat([7, -1, 3], [300, 300, 2])


def test_each_segment_is_fitted_as_alone_and_a_bad_one_does_not_stop_it() -> None:
    mixed = RNG.permutation(602)
    weights = RNG.uniform(1, 2, 602)
    segments = primfit.fit_segments(
        SPHERES[mixed], LABELS[mixed], normals=SPHERE_NORMALS[mixed], weights=weights, seed=4
    )
    assert [segment.label for segment in segments] == [-1, 3, 7]
    assert [type(segment.label) for segment in segments] == [int] * 3
    for segment in segments:
        np.testing.assert_array_equal(segment.rows, np.flatnonzero(LABELS[mixed] == segment.label))
        if segment.label == 3:
            assert segment.recognition is None and "2 points given" in segment.problem
            continue
        expected = primfit.fit(
            SPHERES[mixed][segment.rows],
            normals=SPHERE_NORMALS[mixed][segment.rows],
            weights=weights[segment.rows],
            seed=4,
        )
        assert segment.problem == ""
        assert segment.recognition is not None and expected.primitive is not None
        none = Cloud(SPHERES, (), None, "")
        assert answer(segment.recognition, none, {}) == answer(expected, none, {})


@pytest.mark.parametrize(
    ("labels", "expected"),
    [
        ([2.0, 1.0, 2.0], [(1, [1]), (2, [0, 2])]),
        (["b", "a", "b"], [("a", [1]), ("b", [0, 2])]),
        (np.array(["b", "a", "b"], object), [("a", [1]), ("b", [0, 2])]),
        ([True, False, True], [(0, [1]), (1, [0, 2])]),
        (np.array([2**63, 1, 1], np.uint64), [(1, [1, 2]), (2**63, [0])]),
        (np.array([], int), []),
    ],
    ids=["whole floats", "strings", "objects", "booleans", "unsigned", "none"],
)
def test_labels_are_whole_numbers_or_strings(
    labels: object, expected: list[tuple[object, list[int]]]
) -> None:
    array = np.asarray(labels)
    found = cut(array, {"points": np.zeros((len(array), 3))})
    assert [(label, rows.tolist()) for label, rows in found] == expected
    assert all(type(label) in (int, str) for label, _ in found)


BAD = {
    "NaN": ([1.0, np.nan, 2.0], "whole numbers"),
    "infinity": ([1.0, np.inf, 2.0], "whole numbers"),
    "fractions": ([1.0, 1.5, 2.0], "whole numbers"),
    "objects": ([1, None, "a"], "whole numbers"),
    "bytes": ([b"a", b"b", b"c"], "whole numbers"),
    "two columns": ([[1, 2]] * 3, r"shape \(3, 2\)"),
    "too few": ([1, 2], r"shape \(2,\)"),
}


@pytest.mark.parametrize(("labels", "said"), BAD.values(), ids=BAD)
def test_other_labels_are_refused(labels: list[object], said: str) -> None:
    with pytest.raises(InvalidPointCloudError, match=said) as caught:
        primfit.fit_segments(np.zeros((3, 3)), labels)
    assert caught.value.field == "labels"


def test_what_is_wrong_for_all_is_raised() -> None:
    with pytest.raises(InvalidOptionError):
        primfit.fit_segments(SPHERES, LABELS, kinds=["cube"])
    with pytest.raises(InvalidPointCloudError, match="normals have shape") as caught:
        primfit.fit_segments(SPHERES, LABELS, normals=NORMALS)
    assert caught.value.field == "normals"
    with pytest.raises(InvalidPointCloudError, match="not an array"):
        primfit.fit_segments([[1, 2, 3], [4, 5]], [1, 1])


def test_a_part_of_a_cloud_is_a_cloud_without_labels() -> None:
    cloud = Cloud(SPHERES, ("x", "y", "z"), SPHERE_NORMALS, "text", labels=LABELS, label_column="id")
    cut_by_label = cut_cloud(cloud)
    assert cut_by_label is not None
    (_, rows), *_ = cut_by_label
    segment = part(cloud, rows)
    assert segment.labels is None and segment.label_column is None
    assert segment.normals is not None and len(segment.points) == len(segment.normals) == 300
    assert cut_cloud(segment) is None
