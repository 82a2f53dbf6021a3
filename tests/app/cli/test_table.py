"""`primfit table`: rows of a run are chosen, counted, joined and written in every format."""

import csv
import json
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

import primfit
from primfit.app.bulk.parts import Run
from primfit.app.bulk.tasks import Task
from primfit.app.cli.commands import app
from primfit.app.engine.segments import Segment
from tests.app.bulk.recognized import NAMES, found, ref, rows

pytest.importorskip("duckdb", reason="needs duckdb, of the extra bulk")
parquet = pytest.importorskip("pyarrow.parquet", reason="needs pyarrow, of the extra bulk")


def run(*args: object) -> Result:
    return CliRunner().invoke(app, ["table", *map(str, args)])


def told(*args: object) -> list[dict[str, str]]:
    """What is printed as CSV."""
    result = run(*args, "--format", "csv")
    assert (result.exit_code, result.stderr) == (0, "")
    return list(csv.DictReader(StringIO(result.stdout)))


def write_run(out: Path, n_tasks: int = 3) -> Path:
    """All rows, of four segments a task."""
    tasks = [Task(i, tuple(map(ref, range(4 * i, min(4 * i + 4, len(NAMES)))))) for i in range(3)]
    begun = Run.begin(out, {"names": ["scans"]}, {}, lambda scratch: tasks)
    for task in tasks[:n_tasks]:
        begun.finished(task, begun.writer.write(task, rows()[4 * task.number : 4 * task.number + 4]))
    begun.end()
    return out


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run; the name of its folder is one that needs care in SQL, and in patterns."""
    return write_run(tmp_path_factory.mktemp("it's [1]*"))


def test_people_see_a_few_columns(out: Path) -> None:
    result = run(out)
    lines = result.stdout.splitlines()
    assert (result.exit_code, result.stderr, len(lines)) == (0, "", 11)
    assert lines[0].split() == ["id", "status", "kind", "n_points", "radius", "inlier_rms", "message"]
    assert lines[2].split()[:4] == ["scans/hall.las#1", "fitted", "sphere", "300"]
    assert lines[10].split()[:3] == ["scans/hall.las#9", "problem", "-"]


def test_rows_are_chosen_in_the_order_of_the_run(out: Path) -> None:
    chosen = told(out, "--where", "status = 'fitted' AND inlier_rms < 0.1", "--columns", "id, kind")
    assert [row["kind"] for row in chosen] == ["plane", "sphere", "cylinder", "cone", "torus", "sphere"]
    assert [row["id"][-1] for row in chosen] == ["0", "1", "2", "3", "4", "8"]


def test_columns_are_expressions(out: Path) -> None:
    (row,) = told(out, "--where", "kind = 'cylinder'", "--columns", "2 * radius AS diameter, bbox.xmin")
    assert float(row["diameter"]) == 2 * found("cylinder")[0].primitive.radius  # type: ignore[union-attr]
    assert float(row["xmin"]) == rows()[2]["bbox"]["xmin"]


def test_a_table_has_every_column_that_a_text_can_have(out: Path) -> None:
    (row,) = told(out, "--where", "label = '1'")
    assert row["status"] == "fitted" and row["half_angle"] == ""
    assert float(row["radius_low"]) < float(row["radius"]) < float(row["radius_high"])
    assert not {"receipt", "answer", "bbox", "geometry"} & row.keys()


def test_it_counts_the_most_first(out: Path) -> None:
    assert told(out, "--count", "status") == [
        {"status": "fitted", "count": "6"},
        {"status": "no_fit", "count": "2"},
        {"status": "ambiguous", "count": "1"},
        {"status": "problem", "count": "1"},
    ]
    both = told(out, "--count", "status, kind", "--where", "kind IS NOT NULL", "--limit", 1)
    assert both == [{"status": "fitted", "kind": "sphere", "count": "2"}]


@pytest.mark.parametrize("suffix", ["csv", "json", "parquet"])
def test_it_joins_columns_of_a_file(suffix: str, out: Path, tmp_path: Path) -> None:
    more = [{"label": "1", "kind": "vessel", "cost": 7.5}, {"label": "4", "kind": "bend", "cost": 2.5}]
    file = tmp_path / f"it's [2].{suffix}"
    if suffix == "csv":
        file.write_text(
            "label,kind,cost\n" + "".join(f"{','.join(map(str, row.values()))}\n" for row in more)
        )
    elif suffix == "json":
        file.write_text(json.dumps(more))
    else:
        import pyarrow

        parquet.write_table(pyarrow.Table.from_pylist(more), file)
    chosen = told(out, "--join", file, "--on", "label", "--columns", "label, kind, joined_kind, cost")
    assert [row["label"] for row in chosen] == list("0123456789")
    assert chosen[1] == {"label": "1", "kind": "sphere", "joined_kind": "vessel", "cost": "7.5"}
    assert chosen[2] == {"label": "2", "kind": "cylinder", "joined_kind": "", "cost": ""}
    (dear,) = told(out, "--join", file, "--on", "label", "--where", "cost > 5", "--columns", "label")
    assert dear == {"label": "1"}


def test_keys_of_a_text_are_texts(out: Path, tmp_path: Path) -> None:
    (tmp_path / "more.csv").write_text("label,tag\n01,a\n1,b\n")
    (row,) = told(out, "--join", tmp_path / "more.csv", "--on", "label", "--where", "tag IS NOT NULL")
    assert (row["label"], row["tag"]) == ("1", "b")


def test_a_key_that_is_there_twice_is_refused(out: Path, tmp_path: Path) -> None:
    (tmp_path / "more.csv").write_text("label,tag\n1,a\n1,b\n")
    result = run(out, "--join", tmp_path / "more.csv", "--on", "label")
    assert result.exit_code == 2
    assert result.stderr == f"primfit: table: {tmp_path / 'more.csv'} has the label '1' more than once\n"


def test_parquet_of_a_selection_is_asked_like_a_run(out: Path, tmp_path: Path) -> None:
    file = tmp_path / "fitted.parquet"
    assert run(out, "--where", "status = 'fitted'", "--format", "parquet", "--out", file).exit_code == 0
    assert told(file) == told(out, "--where", "status = 'fitted'")
    table = parquet.read_table(file)
    assert table.column("geometry").to_pylist()[1] == rows()[1]["geometry"]
    geo = json.loads(table.schema.metadata[b"geo"])
    assert geo["version"] == "1.1.0" and geo["columns"]["geometry"]["encoding"] == "WKB"
    assert json.loads(table.schema.metadata[b"primfit"])["version"] == 1
    few = tmp_path / "few.parquet"
    assert run(file, "--columns", "id, kind", "--format", "parquet", "--out", few).exit_code == 0
    assert parquet.read_table(few).schema.names == ["id", "kind"]
    assert b"geo" not in parquet.read_table(few).schema.metadata


@pytest.mark.parametrize("format", ["step", "glb"])
def test_exports_of_a_selection_are_those_of_the_fits(format: str, out: Path, tmp_path: Path) -> None:
    file = tmp_path / f"some.{format}"
    result = run(out, "--where", "kind IN ('cylinder', 'torus')", "--format", format, "--out", file)
    assert (result.exit_code, result.stderr) == (0, "")
    fits: Any = [Segment(ref(i).id, None, found(NAMES[i])[0], "") for i in (2, 4)]  # type: ignore[arg-type, call-arg]
    assert file.read_bytes() == primfit.export_segments(fits, format)


def test_a_report_lists_problems_too(out: Path, tmp_path: Path) -> None:
    assert run(out, "--format", "report", "--out", tmp_path / "all.html").exit_code == 0
    page = (tmp_path / "all.html").read_text()
    assert "10 clouds" in page and "2 points; at least 3 are needed" in page and "hall.las#4" in page


def test_a_run_that_is_not_finished_is_told_of(tmp_path: Path) -> None:
    result = run(write_run(tmp_path, 2), "--count", "status")
    assert result.exit_code == 0
    assert result.stderr == f"primfit: {tmp_path}: the run is not finished: 2 of 3 tasks\n"


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["--where", "radius >"], 'table: Parser Error: syntax error at or near ")"'),
        (["--where", "size > 1"], 'table: Binder Error: Referenced column "size" not found in FROM clause!'),
        (["--columns", "id; SELECT 1"], "table: one expression is needed, not several statements"),
        (["--where", "1 = 1); SELECT (1"], "table: one expression is needed, not several statements"),
        (["--count", "nope"], 'table: Binder Error: Referenced column "nope"'),
        (["--count", "kind", "--columns", "id"], "--count: it names the columns"),
        (["--on", "id"], "--on: there is no --join FILE"),
        (["--unit", "m"], "--unit: it is for glb, step, report"),
        (["--format", "glb"], "--out: a file is needed for glb"),
        (["--format", "step", "--count", "kind", "--out", "x.step"], "--format: step has no columns"),
        (["--join", "more.txt"], "table: more.txt is none of .csv, .tsv, .parquet, .json, .ndjson"),
    ],
    ids=str,
)
def test_what_cannot_be_asked_is_told_in_a_line(args: list[str], said: str, out: Path) -> None:
    result = run(out, *args)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"primfit: {said}") and result.stderr.count("\n") == 1


def test_nothing_to_export_is_told(out: Path, tmp_path: Path) -> None:
    file = tmp_path / "none.glb"
    result = run(out, "--where", "status = 'problem'", "--format", "glb", "--out", file)
    assert result.exit_code == 2 and "no answer has a primitive that can be trimmed" in result.stderr
    assert not file.exists()


def test_a_part_is_not_written_over(out: Path) -> None:
    part = out / "part-000001.parquet"
    before = part.read_bytes()
    result = run(out, "--format", "parquet", "--out", part)
    assert result.exit_code == 2 and "it would overwrite the input" in result.stderr
    assert part.read_bytes() == before


@pytest.mark.parametrize("place", ["nothing", "empty"])
def test_a_place_without_rows_is_told(place: str, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    result = run(tmp_path / place)
    assert result.exit_code == 2 and "holds no part-*.parquet" in result.stderr


def test_more_rows_than_are_shown_are_told_of(tmp_path: Path) -> None:
    import pyarrow

    file = tmp_path / "many.parquet"
    parquet.write_table(pyarrow.table({"id": [f"a\x1b[2J{i}" for i in range(50)]}), file)
    lines = run(file).stdout.splitlines()
    assert len(lines) == 42 and lines[-1] == "(the first 40; --limit shows more)"
    assert lines[1] == "a?[2J0"
    assert len(run(file, "--limit", 45).stdout.splitlines()) == 46
