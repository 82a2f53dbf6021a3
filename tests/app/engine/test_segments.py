"""The segments of a cloud, in Python: the numbers of `fit`, in the order of the labels."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import primfit
from primfit.app.engine.answer import answer
from primfit.app.engine.cut import cut, cut_cloud, pieces
from primfit.app.readers.cloud import Cloud
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError

RNG = np.random.default_rng(8)
NORMALS = RNG.normal(size=(300, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)
SPHERES = np.vstack([NORMALS, 2 * NORMALS + 5, [[0, 0, 0], [1, 1, 1]]])
SPHERE_NORMALS = np.vstack([NORMALS, NORMALS, [[0, 0, 1]] * 2])
LABELS = np.repeat([7, -1, 3], [300, 300, 2])


@pytest.mark.parametrize("workers", [1, 2])
def test_each_segment_is_fitted_as_alone_and_a_bad_one_does_not_stop_it(workers: int) -> None:
    mixed = RNG.permutation(602)
    weights = RNG.uniform(1, 2, 602)
    segments = primfit.fit_segments(
        SPHERES[mixed],
        LABELS[mixed],
        workers=workers,
        normals=SPHERE_NORMALS[mixed],
        weights=weights,
        seed=4,
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
        (np.array([2**64 - 1, 2**64 - 9, 2**64 - 1], np.uint64), [(2**64 - 9, [1]), (2**64 - 1, [0, 2])]),
        (np.array([127, -128, 0, -128], np.int8), [(-128, [1, 3]), (0, [2]), (127, [0])]),
        ([65_530, -5, 65_530], [(-5, [1]), (65_530, [0, 2])]),
        ([65_531, -5, 65_531], [(-5, [1]), (65_531, [0, 2])]),
        ([-70_000, -70_003, -70_000], [(-70_003, [1]), (-70_000, [0, 2])]),
        (np.array([], int), []),
    ],
    ids=[
        *("whole floats", "strings", "objects", "booleans", "unsigned", "largest", "narrow"),
        *("16 bits", "over 16 bits", "16 bits from below", "none"),
    ],
)
def test_labels_are_whole_numbers_or_strings(
    labels: object, expected: list[tuple[object, list[int]]]
) -> None:
    array = np.asarray(labels)
    found = list(cut(Cloud(np.zeros((len(array), 3)), ("x", "y", "z"), None, "text", labels=array)))
    assert [(label, rows.tolist()) for label, rows, _ in found] == expected
    assert all(type(label) in (int, str) and len(part.points) == len(rows) for label, rows, part in found)


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
    with pytest.raises(InvalidOptionError, match="at least 1"):
        primfit.fit_segments(SPHERES, LABELS, workers=0)
    with pytest.raises(InvalidPointCloudError, match="normals have shape") as caught:
        primfit.fit_segments(SPHERES, LABELS, normals=NORMALS)
    assert caught.value.field == "normals"
    with pytest.raises(InvalidPointCloudError, match="not an array"):
        primfit.fit_segments([[1, 2, 3], [4, 5]], [1, 1])


def test_a_segment_of_a_cloud_is_a_cloud_without_labels() -> None:
    cloud = Cloud(SPHERES, ("x", "y", "z"), SPHERE_NORMALS, "text", labels=LABELS, label_column="id")
    cut_by_label = cut_cloud(cloud)
    assert cut_by_label is not None
    (_, _, segment), *_ = cut_by_label
    assert segment.labels is None
    assert segment.normals is not None and len(segment.points) == len(segment.normals) == 300
    assert cut_cloud(segment) is None


@pytest.mark.parametrize("beside", [{}, {"normals": SPHERE_NORMALS}, {"weights": np.arange(602.0)}])
def test_a_stored_segment_is_that_of_the_cloud(beside: dict[str, np.ndarray], tmp_path: Path) -> None:
    arrays = {"normals": None, **beside}
    mixed = RNG.permutation(602)
    whole = cut(
        Cloud(SPHERES.astype(np.float32), ("x", "y", "z"), format="text", labels=LABELS[mixed], **arrays)
    )
    scratch = tmp_path / "scratch"
    stored = pickle.loads(pickle.dumps(pieces(whole, scratch)))
    assert scratch.stat().st_size == 8 * sum(array.size for array in (SPHERES, *beside.values()))
    for here, there, (_, rows, _) in zip(pieces(whole), stored, whole, strict=True):
        expected, found = vars(here()), vars(there())
        assert expected.keys() == found.keys()
        for name, value in expected.items():
            np.testing.assert_array_equal(found[name], value)
        assert found["points"].dtype == np.float64 and found["points"].flags.c_contiguous
        np.testing.assert_array_equal(found["points"], SPHERES.astype(np.float32)[rows])
