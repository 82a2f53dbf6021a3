"""A scan in random order and its segments: the same points and answers, and what is said of the times."""

import numpy as np
import pytest

from primfit.benchmark.scaling.scan import LABEL, Scan, ScanRecord, measured, told

parquet = pytest.importorskip("pyarrow.parquet", reason="needs pyarrow, of the extra bulk")
laspy = pytest.importorskip("laspy")


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Scan:
    made = Scan(tmp_path_factory.mktemp("scan"), 12, 80, 3)
    made.draw()
    return made


def test_its_segments_are_those_of_the_file(scan: Scan) -> None:
    points = laspy.read(str(scan.file))
    labels = np.asarray(points[LABEL])
    assert len(labels) == scan.total and np.count_nonzero(np.diff(labels)) > 0.8 * scan.total
    rows = parquet.read_table(str(scan.rows[0]))["points"].to_pylist()
    for label, own in enumerate(rows):
        np.testing.assert_array_equal(np.asarray(points.xyz)[labels == label], np.array(own))


def test_it_is_drawn_once(scan: Scan) -> None:
    before = scan.file.stat().st_mtime_ns
    scan.draw()
    assert scan.file.stat().st_mtime_ns == before


@pytest.mark.slow
def test_its_answers_are_those_of_its_segments(scan: Scan) -> None:
    record = measured(scan)
    assert record.answers == record.segments == 12 and record.points == scan.total
    assert 0 <= record.read < record.whole and record.memory > 0


def test_the_ratio_is_that_to_reading_and_fitting() -> None:
    record = ScanRecord(10, 1000, "", "", 2.0, 8.0, 15.0, 400.0, 10)
    assert "1.50 times both" in told(record)
