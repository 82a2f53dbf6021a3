"""Grouping on disk gives what `engine.cut` gives for the whole cloud."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from primfit.app.bulk import grouping
from primfit.app.engine.cut import cut
from primfit.app.readers import Cloud
from primfit.app.readers.cloud import selected
from primfit.fitting.errors import InvalidPointCloudError

RNG = np.random.default_rng(21)
N = 5000
LABELS: dict[str, np.ndarray] = {
    "in random order": RNG.integers(0, 40, N),
    "far apart": RNG.choice(np.array([-(2**63), -7, 0, 3, 2**40, 2**63 - 1]), N),
    "negative": RNG.integers(-300, -100, N),
    "skewed": np.where(RNG.random(N) < 0.9, 5, RNG.integers(0, 1000, N)),
    "one": np.full(N, 12),
    "each its own": RNG.permutation(N),
    "strings": RNG.choice(np.array(["10", "9", "Ärmel", "wall", "Wall", ""]), N).astype(object),
    "long strings": np.array([f"{'pipe' * 40} {i % 97}" for i in range(N)], object),
    "floats": RNG.integers(-3, 3, N).astype(np.float64),
}


def cloud_of(labels: np.ndarray, normals: bool = False) -> Cloud:
    points = RNG.normal(size=(len(labels), 3))
    points[::97] = np.nan
    points[5::97] = 0.0
    given = RNG.normal(size=points.shape) if normals else None
    names = ("x", "y", "z", "nx", "ny", "nz")[: 6 if normals else 3]
    return Cloud(
        points, names, given, "las", labels=labels, label_column="part", unit="m", unit_from="format"
    )


def in_pieces(cloud: Cloud, n_points: int) -> Iterator[Cloud]:
    assert cloud.labels is not None
    for start in range(0, len(cloud.points), n_points):
        rows = np.arange(start, min(start + n_points, len(cloud.points)))
        yield selected(cloud, rows, labels=cloud.labels[rows])


def grouped(cloud: Cloud, folder: Path, n_points: int, n_buckets: int) -> list[tuple[Any, Cloud]]:
    store = grouping.store_in(str(folder), "scan")
    grouping.group(in_pieces(cloud, n_points), Path(store), n_buckets)
    assert grouping.is_whole(store) and not list(folder.glob("*.buckets"))
    grouping._head.cache_clear()  # tests write several stores to one place
    return [(label, grouping.segment(store, start, stop)) for label, start, stop in grouping.segments(store)]


def check_same(found: list[tuple[Any, Cloud]], cloud: Cloud) -> None:
    expected = [(label, segment) for label, _, segment in cut(cloud)]
    assert [label for label, _ in found] == [label for label, _ in expected]
    for (_, ours), (_, theirs) in zip(found, expected, strict=True):
        assert ours.points.tobytes() == theirs.points.tobytes()
        assert (ours.normals is None) == (theirs.normals is None)
        if ours.normals is not None and theirs.normals is not None:
            assert ours.normals.tobytes() == theirs.normals.tobytes()
        bare = {"points": np.empty((0, 3)), "normals": None}
        assert replace(ours, **bare) == replace(theirs, **bare)


@pytest.mark.parametrize("labels", LABELS.values(), ids=LABELS.keys())
@pytest.mark.parametrize(("n_points", "n_buckets"), [(N, 1), (700, 1), (700, 7), (333, 64), (1, 3)])
def test_segments_are_those_of_the_whole_cloud(
    labels: np.ndarray, n_points: int, n_buckets: int, tmp_path: Path
) -> None:
    size = N if n_points > 1 else 200
    cloud = cloud_of(labels[:size])
    check_same(grouped(cloud, tmp_path, n_points, n_buckets), cloud)


def test_several_pieces_of_a_bucket_keep_the_order_of_points(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(grouping, "PIECE", 100)
    for labels in (LABELS["skewed"], LABELS["strings"]):
        cloud = cloud_of(labels, normals=True)
        check_same(grouped(cloud, tmp_path, 450, 3), cloud)


def test_normals_of_which_one_has_no_direction_are_not_trusted(tmp_path: Path) -> None:
    cloud = cloud_of(LABELS["in random order"], normals=True)
    first, *rest = in_pieces(cloud, 900)
    rest[2] = replace(rest[2], normals=None, columns=("x", "y", "z"))
    store = grouping.store_in(str(tmp_path), "scan")
    grouping.group([first, *rest], Path(store), 4)
    _, start, stop = next(grouping.segments(store))
    segment = grouping.segment(store, start, stop)
    assert segment.normals is None
    assert segment.columns == ("x", "y", "z")


def test_the_number_of_buckets_and_pieces_leaves_the_same_bytes(tmp_path: Path) -> None:
    cloud, found = cloud_of(LABELS["skewed"]), set()
    for n_points, n_buckets in ((N, 1), (701, 5), (64, 200)):
        grouped(cloud, tmp_path, n_points, n_buckets)
        found.add(tuple(Path(part).read_bytes() for part in grouping.parts(str(tmp_path / "scan.segments"))))
    assert len(found) == 1


def test_labels_that_are_fractions_are_refused_and_leave_nothing(tmp_path: Path) -> None:
    cloud = cloud_of(np.linspace(0.0, 1.0, N))
    store = grouping.store_in(str(tmp_path), "scan")
    with pytest.raises(InvalidPointCloudError, match="whole numbers"):
        grouping.group(in_pieces(cloud, 999), Path(store), 4)
    assert not grouping.is_whole(store)
    assert list(tmp_path.iterdir()) == []
