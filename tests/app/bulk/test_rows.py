"""A row a segment: every kind and status, read by others, in valid GeoParquet, always the same bytes."""

import json
import re
import struct
import subprocess
import sys
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pytest

from primfit.app.bulk.rows import BOX, geo_of, problem_row, schema, told_of, written
from primfit.app.engine.answer import to_json
from primfit.fitting.names import KINDS
from primfit.fitting.primitives import names_of, values_of
from tests.app.bulk.recognized import NAMES, PROBLEM, found, ref, rows

pyarrow = pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra bulk")
parquet = pytest.importorskip("pyarrow.parquet")


@pytest.fixture(scope="module")
def content() -> bytes:
    return written(rows(), {"run": "abc", "task": 7, "points": 2700})


@pytest.fixture(scope="module")
def read(content: bytes) -> dict[str, dict[str, Any]]:
    """Each row as it is read back."""
    return dict(zip(NAMES, parquet.read_table(BytesIO(content)).to_pylist(), strict=True))


def test_the_first_column_is_a_unique_id(content: bytes) -> None:
    table = parquet.read_table(BytesIO(content))
    assert table.schema.names[0] == "id"
    assert len(set(table.column("id").to_pylist())) == len(NAMES)
    assert not table.schema.field("id").nullable


def test_statuses_and_kinds_are_those_of_the_answers(read: dict[str, dict[str, Any]]) -> None:
    assert {name: row["status"] for name, row in read.items()} == {
        **dict.fromkeys((*KINDS, "outlier"), "fitted"),
        "ambiguous": "ambiguous",
        **dict.fromkeys(("no_fit", "no primitive"), "no_fit"),
        "problem": "problem",
    }
    assert all(read[kind]["kind"] == kind for kind in KINDS)
    assert read["no primitive"]["kind"] is None
    assert read["ambiguous"]["alternatives"] == [
        other.primitive.kind for other in found("ambiguous")[0].alternatives
    ]


@pytest.mark.parametrize("kind", KINDS)
def test_a_row_has_the_numbers_of_its_answer(kind: str, read: dict[str, dict[str, Any]]) -> None:
    recognition, answer = found(kind)
    row = read[kind]
    assert recognition.primitive and recognition.error and recognition.uncertainty
    numbers = {
        name.replace(".", "_"): value
        for name, value in zip(names_of(kind), values_of(recognition.primitive), strict=True)
    }
    assert {name: row[name] for name in numbers} == numbers
    others = {name.replace(".", "_") for other in KINDS for name in names_of(other)} - set(numbers)
    assert all(row[name] is None for name in others)
    assert {name: row[name] for name in answer["error"]} == answer["error"]
    for name, interval in recognition.uncertainty.intervals.items():
        column = name.replace(".", "_")
        ends = [row[f"{column}_{end}"] for end in ("low", "high", "standard_deviation")]
        assert ends == [interval.low, interval.high, interval.standard_deviation]
    for attempt in recognition.attempts:
        assert row[f"evidence_{attempt.kind}"] == attempt.evidence
        assert row[f"probability_{attempt.kind}"] == attempt.probability
    assert (row["n_points"], row["unit"], row["noise_model"]) == (
        300,
        "m",
        recognition.uncertainty.noise_model,
    )
    assert row["noise_scale"] == recognition.noise.scale  # type: ignore[union-attr]
    assert row["area"] == answer["extents"]["area"]
    assert row["answer"].encode() == to_json(answer)
    assert orjson.loads(row["receipt"]) == orjson.loads(row["answer"])["receipt"]
    assert row["input_sha256"] == answer["receipt"]["input_sha256"]


def test_a_problem_has_its_message_and_nothing_else(read: dict[str, dict[str, Any]]) -> None:
    there = {name: value for name, value in read["problem"].items() if value is not None}
    assert there == {
        "id": "scans/hall.las#9",
        "file": "scans/hall.las",
        "label": "9",
        "status": "problem",
        "message": PROBLEM,
    }


def test_no_cell_of_a_row_is_without_a_column() -> None:
    assert {name for row in rows() for name in row} <= set(schema().names)


def test_every_column_has_a_value_in_some_row(content: bytes) -> None:
    table = parquet.read_table(BytesIO(content))
    empty = {name for name in table.schema.names if table.column(name).null_count == len(table)}
    deviations = {f"noise_{of}_{end}" for of in ("correlated", "smooth") for end in ("size", "range")}
    assert empty <= deviations | {"noise_quantisation_step", "conformance"}


def test_the_box_holds_the_points_that_belong_to_the_primitive(read: dict[str, dict[str, Any]]) -> None:
    box = read["outlier"]["bbox"]
    points = found("outlier")[0].kept_points()[found("outlier")[0].inliers]
    assert max(box.values()) < 5.0
    assert list(box.values()) == [*points.min(axis=0), *points.max(axis=0)]
    whole = found("no_fit")[0].kept_points()
    assert list(read["no_fit"]["bbox"].values()) == [*whole.min(axis=0), *whole.max(axis=0)]


def test_the_geometry_is_the_center_of_the_box(read: dict[str, dict[str, Any]]) -> None:
    shapely = pytest.importorskip("shapely")
    for name in (*KINDS, "no_fit"):
        box = np.array(list(read[name]["bbox"].values())).reshape(2, 3)
        point = shapely.from_wkb(
            struct.pack("<BI3d", 1, 0x80000001, *struct.unpack("<BI3d", read[name]["geometry"])[2:])
        )
        iso = shapely.from_wkb(read[name]["geometry"])
        assert iso.has_z and iso.equals(point)
        assert np.allclose([iso.x, iso.y, iso.z], box.mean(axis=0), rtol=0, atol=1e-12)


def test_the_metadata_is_that_of_geoparquet_1_1(content: bytes) -> None:
    """Held against the rules of the specification, https://geoparquet.org/releases/v1.1.0."""
    file = parquet.ParquetFile(BytesIO(content))
    geo = json.loads(file.schema_arrow.metadata[b"geo"])
    assert re.fullmatch(r"1\.1\.\d+", geo["version"])
    assert geo.keys() == {"version", "primary_column", "columns"}
    column = geo["columns"][geo["primary_column"]]
    assert column.keys() == {"encoding", "geometry_types", "crs", "covering", "bbox"}
    assert column["encoding"] == "WKB" and column["geometry_types"] == ["Point Z"] and column["crs"] is None
    types = file.schema_arrow
    assert types.field(geo["primary_column"]).type == pyarrow.binary()
    covering = column["covering"]["bbox"]
    assert covering.keys() == {"xmin", "ymin", "xmax", "ymax"}
    for side, path in covering.items():
        assert path == ["bbox", side] and types.field("bbox").type.field(side).type == pyarrow.float64()
    assert [field.name for field in types.field("bbox").type] == list(BOX)
    centers = np.array([struct.unpack("<BI3d", row["geometry"])[2:] for row in rows() if row.get("geometry")])
    assert column["bbox"] == [*centers.min(axis=0), *centers.max(axis=0)]


def test_without_geometries_no_box_of_all_is_told() -> None:
    content = written([problem_row(ref(0), PROBLEM)], {})
    geo = json.loads(parquet.ParquetFile(BytesIO(content)).schema_arrow.metadata[b"geo"])
    assert "bbox" not in geo["columns"]["geometry"]
    assert json.loads(geo_of([0, 0, 0, 1, 1, 1]))["columns"]["geometry"]["bbox"] == [0, 0, 0, 1, 1, 1]


def test_duckdb_reads_it(content: bytes, tmp_path: Path) -> None:
    duckdb = pytest.importorskip("duckdb", reason="needs duckdb, of the extra bulk")
    (tmp_path / "part-000000.parquet").write_bytes(content)
    asked = "SELECT id, radius, bbox.xmin FROM read_parquet(?) WHERE kind = 'sphere' AND status = 'fitted'"
    rows_read = duckdb.execute(asked, [str(tmp_path / "part-*.parquet")]).fetchall()
    assert rows_read[0] == (
        "scans/hall.las#1",
        found("sphere")[0].primitive.radius,
        rows()[1]["bbox"]["xmin"],
    )  # type: ignore[union-attr]
    assert [row[0] for row in rows_read] == ["scans/hall.las#1", "scans/hall.las#8"]


def test_pandas_reads_it(content: bytes) -> None:
    pandas = pytest.importorskip("pandas")
    frame = pandas.read_parquet(BytesIO(content), engine="pyarrow").set_index("id")
    assert frame.loc["scans/hall.las#2", "kind"] == "cylinder"
    assert frame.status.value_counts().to_dict() == {"fitted": 6, "no_fit": 2, "ambiguous": 1, "problem": 1}


def test_the_file_says_what_it_is(content: bytes) -> None:
    told = told_of(content)
    assert told is not None
    assert told.about == {"schema": "primfit.answers", "version": 1, "run": "abc", "task": 7, "points": 2700}
    assert told.statuses == [row["status"] for row in rows()]


@pytest.mark.parametrize("share", [0.0, 0.5, 0.999])
def test_half_a_file_says_nothing(content: bytes, share: float) -> None:
    assert told_of(content[: int(share * len(content))]) is None


def test_a_parquet_file_of_others_says_nothing() -> None:
    stream = BytesIO()
    parquet.write_table(pyarrow.table({"status": ["fitted"]}), stream)
    assert told_of(stream.getvalue()) is None


def test_the_same_rows_are_the_same_bytes_in_another_process(content: bytes) -> None:
    script = (
        "import sys; from tests.app.bulk.recognized import *; from primfit.app.bulk.rows import written\n"
        "sys.stdout.buffer.write(written(rows(), {'run': 'abc', 'task': 7, 'points': 2700}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, check=True, cwd=Path(__file__).parents[3]
    )
    assert done.stdout == content
