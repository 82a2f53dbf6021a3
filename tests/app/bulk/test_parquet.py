"""Parquet files as inputs, written by pyarrow."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from primfit.app.bulk import parquet
from primfit.app.bulk.refs import Ref, cloud_at
from primfit.app.bulk.sources import references
from primfit.app.readers import UnreadableFileError

pa = pytest.importorskip("pyarrow", reason="pyarrow comes with the extra bulk")
pq = pytest.importorskip("pyarrow.parquet", reason="pyarrow comes with the extra bulk")

RNG = np.random.default_rng(8)
CLOUDS = [RNG.normal(size=(n, 3)) for n in RNG.integers(0, 60, 500)]
NAMES = [f"part {i}" for i in range(500)]
SEGMENT = pa.list_(pa.list_(pa.float64(), 3))


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of its own, which names are relative to."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def found(*inputs: str, labels: str | None = None, columns: Any = None) -> list[Ref]:
    return list(references(inputs, labels, columns, "scratch"))


def write(name: str, columns: dict[str, Any], **options: Any) -> None:
    pq.write_table(pa.table(columns), name, **options)


def triples(kind: Any = SEGMENT) -> Any:
    return pa.array([cloud.tolist() for cloud in CLOUDS], kind)


def lists(column: int, kind: Any = None) -> Any:
    return pa.array([cloud[:, column].tolist() for cloud in CLOUDS], kind or pa.list_(pa.float64()))


SHAPES = {
    "fixed": lambda: {"points": triples()},
    "lists of lists": lambda: {"points": triples(pa.list_(pa.list_(pa.float64())))},
    "large lists": lambda: {"points": triples(pa.large_list(pa.list_(pa.float64(), 3)))},
    "x, y, z": lambda: {"X": lists(0), "y": lists(1), "z": lists(2)},
}


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())
@pytest.mark.parametrize("group_size", [7, 100, 1000])
def test_a_row_a_segment(shape: Any, group_size: int) -> None:
    write("s.parquet", {"id": NAMES, **shape(), "other": NAMES}, row_group_size=group_size)
    refs = found("s.parquet")
    assert [ref.id for ref in refs] == [f"s.parquet#{name}" for name in NAMES]
    assert [ref.label for ref in refs] == NAMES
    assert [ref.n_points for ref in refs] == list(map(len, CLOUDS))
    for ref, points in [*zip(refs, CLOUDS, strict=True), *list(zip(refs, CLOUDS, strict=True))[::-37]]:
        assert cloud_at(ref, {})[0].points.tobytes() == points.tobytes()


def test_numbers_may_be_ids_and_rows_without_ids_are_numbered() -> None:
    write("s.parquet", {"id": pa.array(range(900, 1400)), "points": triples()})
    write("n.parquet", {"points": triples()})
    assert [ref.label for ref in found("s.parquet")] == list(range(900, 1400))
    assert [ref.id for ref in found("n.parquet")][:2] == ["n.parquet#0", "n.parquet#1"]


def test_normals_and_columns_by_name() -> None:
    named = dict(zip(("x", "y", "z", "nx", "ny", "nz"), (lists(i % 3) for i in range(6)), strict=True))
    write("s.parquet", {"id": NAMES, **named})
    refs = found("s.parquet")
    cloud, _ = cloud_at(refs[3], {})
    assert cloud.normals is not None
    assert np.allclose(cloud.normals, CLOUDS[3] / np.linalg.norm(CLOUDS[3], axis=1, keepdims=True))
    swapped, _ = cloud_at(refs[3], {"columns": "z,y,x"})
    assert swapped.points.tobytes() == np.ascontiguousarray(CLOUDS[3][:, ::-1]).tobytes()


@pytest.mark.parametrize(
    "labels", [RNG.integers(-3, 40, 3000), RNG.choice(np.array(["a", "wall", "10"]), 3000)]
)
def test_a_row_a_point(labels: np.ndarray) -> None:
    points = RNG.normal(size=(3000, 3))
    columns = {name: points[:, i] for i, name in enumerate("xyz")}
    write("p.parquet", {**columns, "segment": labels}, row_group_size=700)
    refs = found("p.parquet", labels="auto")
    assert [ref.label for ref in refs] == sorted(set(labels.tolist()))
    for ref in refs:
        assert cloud_at(ref, {})[0].points.tobytes() == points[labels == ref.label].tobytes()
    (whole,) = found("p.parquet")
    assert whole.id == "p.parquet"
    assert cloud_at(whole, {})[0].points.tobytes() == points.tobytes()


def test_references(here: Path) -> None:
    (here / "clouds").mkdir()
    for i in range(3):
        np.save(here / "clouds" / f"{i}.npy", CLOUDS[3 + i])
    paths = ["0.npy", str(here / "clouds" / "1.npy"), "2.npy"]
    write("clouds/refs.parquet", {"path": paths, "id": ["a", "b", "c"], "label": pa.array([1, 2, 3])})
    refs = found("clouds/refs.parquet")
    assert [(ref.id, ref.label, ref.file) for ref in refs] == [
        (f"clouds/refs.parquet#{id}", label, path)
        for id, label, path in zip("abc", (1, 2, 3), paths, strict=True)
    ]
    for ref, points in zip(refs, CLOUDS[3:], strict=False):
        assert cloud_at(ref, {})[0].points.tobytes() == points.tobytes()
    write("clouds/bare.parquet", {"path": ["0.npy", "2.npy"]})
    assert [ref.id for ref in found("clouds/bare.parquet")] == [
        "clouds/bare.parquet#0.npy",
        "clouds/bare.parquet#2.npy",
    ]


@pytest.mark.parametrize(
    ("columns", "field", "message"),
    [
        ({"id": [*NAMES[:-1], NAMES[7]], "points": triples()}, "id", "twice"),
        ({"id": [*NAMES[:-1], None], "points": triples()}, "id", "no id"),
        ({"path": ["a.csv", "b.csv", "a.csv"]}, "path", "twice"),
        ({"id": [1.5], "path": ["a.csv"]}, "id", "strings or whole numbers"),
        ({"name": NAMES}, "header", "no column named x, y, z"),
    ],
)
def test_what_is_wrong_is_said_by_the_one_reference(columns: Any, field: str, message: str) -> None:
    write("bad.parquet", columns)
    (ref,) = found("bad.parquet")
    with pytest.raises(UnreadableFileError, match=message) as error:
        cloud_at(ref, {})
    assert error.value.field == field


def test_no_parquet() -> None:
    Path("bad.parquet").write_bytes(b"PAR1 and no more")
    (ref,) = found("bad.parquet")
    with pytest.raises(UnreadableFileError, match="no Parquet file"):
        cloud_at(ref, {})


def test_rows_that_are_no_clouds() -> None:
    points = [None, [[1.0, 2.0]], [], [[1.0, 2.0, None]]]
    write("bad.parquet", {"points": pa.array(points, pa.list_(pa.list_(pa.float64())))})
    missing, short, empty, hole = found("bad.parquet")
    for ref, message in ((missing, "no points"), (short, "three numbers")):
        with pytest.raises(UnreadableFileError, match=message):
            cloud_at(ref, {})
    assert cloud_at(empty, {})[0].points.shape == (0, 3)
    assert np.isnan(cloud_at(hole, {})[0].points[0, 2])


def test_few_rows_of_a_large_group_are_held(monkeypatch: pytest.MonkeyPatch) -> None:
    write("s.parquet", {"points": triples()}, data_page_size=2000)
    refs = found("s.parquet")
    for ref in refs:
        cloud_at(ref, {})
    assert parquet._walk is not None
    assert parquet._walk._batch.num_rows <= 64
