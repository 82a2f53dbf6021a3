"""Records of runs: kept and read, compared, shown in tables."""

from dataclasses import replace

from primfit.benchmark.scaling.compare import compared
from primfit.benchmark.scaling.records import Asked, RunRecord, records, told
from primfit.benchmark.scaling.tables import runs_table
from tests.benchmark.scaling.made import record

LOCAL, RAY = Asked(1000, 1, "local", 2), Asked(1000, 1, "ray", 3)


def test_records_are_kept_and_read(tmp_path):
    many = record(Asked(50_000, 1, "ray", 3, "node", 0.5), killed=9.0)
    for each in (many, record(LOCAL)):
        assert RunRecord.read(each.save(tmp_path)).asked == each.asked
    assert [each.asked.name for each in records(tmp_path)] == ["local-2-1000", "ray-3-50000-node-killed"]
    assert "node killed after 9.0 s" in told(many) and "node killed" not in told(record(LOCAL))


def parts(folder, name, contents):
    (folder / "runs" / name).mkdir(parents=True)
    for number, content in enumerate(contents):
        (folder / "runs" / name / f"part-{number:06}.parquet").write_bytes(content)


def test_runs_are_equal_if_all_their_bytes_are(tmp_path):
    left, right = record(LOCAL), record(RAY)
    parts(tmp_path, left.asked.name, [b"a", b"b"])
    parts(tmp_path, right.asked.name, [b"a", b"b"])
    assert compared(left, right, tmp_path)[0]
    other = tmp_path / "runs" / right.asked.name / "part-000001.parquet"
    other.write_bytes(b"c")
    same, text = compared(left, right, tmp_path)
    assert not same and "different: part-000001.parquet" in text
    other.unlink()
    assert not compared(left, right, tmp_path)[0]


def test_a_segment_that_is_missing_or_there_twice_is_told(tmp_path):
    right = record(RAY)
    for wrong in (record(LOCAL, rows=1001), record(LOCAL, missing=1, unique=999), record(LOCAL, unique=999)):
        same, text = compared(wrong, right, tmp_path)
        assert not same and "local-2-1000: " in text and "NOT each segment once" in text
    assert not compared(record(LOCAL, digest="cd"), right, tmp_path)[0]


def test_the_table_says_what_is_equal_and_what_a_cluster_takes_more(tmp_path):
    killed = replace(RAY, kill="node", at=0.5)
    found = [record(LOCAL), record(RAY, wall=22.0), record(killed, wall=30.0)]
    three = record(replace(LOCAL, workers=3), wall=25.0)
    text = runs_table(found)
    assert "1,000 segments: 3 runs, all parts equal byte for byte, every segment exactly once." in text
    assert "1,000 segments on 3 nodes: +10.0% against 2 processes; bar: +15%." in text
    assert "+10.0% against 2 processes, -12.0% against 3 processes; bar" in runs_table([*found, three])
    text = runs_table([*found[:2], record(killed, digest="cd", missing=1)])
    assert "parts that DIFFER, NOT every segment once" in text
    grown = record(replace(LOCAL, n=5000))
    assert "local, 1,000 to 5,000 segments: own memory of the driver 90 to 90 MiB" in runs_table(
        [*found, grown]
    )
