"""Segments on disk, and what is asked on the command line."""

import sys

import pytest

from primfit.benchmark.command import BAD_INPUT, bench
from primfit.benchmark.scaling.sets import PER_FILE, SegmentSet
from primfit.benchmark.scaling.watch import watching

parquet = pytest.importorskip("pyarrow.parquet", reason="needs pyarrow, which is in the extra bulk")


def test_segments_are_drawn_once_and_the_same(tmp_path, capsys):
    command = ["scaling", "segments", "--n", str(PER_FILE), "--processes", "1", "--folder", str(tmp_path)]
    assert bench(command) == 0 and "files: 1, of which 1 drawn now" in capsys.readouterr().out
    chosen = SegmentSet(tmp_path / "segments", 1, PER_FILE)
    [file] = chosen.files
    content = file.read_bytes()
    assert bench(command) == 0 and "files: 1, of which 0 drawn now" in capsys.readouterr().out
    file.unlink()
    assert bench(command) == 0 and file.read_bytes() == content
    table = parquet.read_table(str(file))
    lengths = [len(points) for points in table["points"].to_pylist()]
    assert lengths == chosen.lengths() and 50 <= min(lengths) and max(lengths) <= 3000
    assert len(set(chosen.ids())) == PER_FILE == table.num_rows
    assert chosen.listed().read_text() == f"{file.absolute()}\n"


def test_a_run_without_segments_and_odd_numbers_are_refused(tmp_path, capsys):
    arguments = ["scaling", "run", "--folder", str(tmp_path), "--n"]
    assert bench([*arguments, str(2 * PER_FILE)]) == BAD_INPUT
    assert "2 of 2 files of segments are not there" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        bench([*arguments, str(PER_FILE + 1)])
    assert f"not a multiple of {PER_FILE}" in capsys.readouterr().err
    assert bench(["scaling", "runs", "--folder", str(tmp_path)]) == BAD_INPUT


@pytest.mark.skipif(sys.platform != "linux", reason="asks /proc, which Linux has")
def test_processes_below_this_one_are_watched():
    import subprocess

    with watching() as watch:
        code = "x = bytearray(50_000_000)\nfor i in range(10**7): pass\ninput()"
        with subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE) as process:
            watch.drivers.add(process.pid)
            while watch.cpu("driver") < 0.1:
                watch.look()
            process.communicate(b"\n")
    # Other tests may have left processes below this one, which are no drivers.
    assert [each.pid for each in watch.known.values() if each.role == "driver"] == [process.pid]
    assert watch.most("driver", "rss") > 50 and watch.cpu("driver") >= 0.1
