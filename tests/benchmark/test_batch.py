"""`primfit bench batch`: real runs of `primfit batch`, and the table."""

import sys

import pytest

from primfit.benchmark.batch import FEW, LEAST, Use, table
from primfit.benchmark.command import bench


@pytest.mark.slow
@pytest.mark.skipif(
    sys.platform == "win32", reason="asks for the time of a process that ended, as POSIX has it"
)
def test_runs_are_measured(capsys):
    assert bench(["batch", "--n", str(LEAST), "--points", "100", "--turns", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "| | 1 process | 2 processes |"
    assert lines[-1].endswith("bar: 5 %.")


@pytest.mark.parametrize(("option", "number"), [("--n", LEAST - 1), ("--points", 9)])
def test_few_clouds_and_points_are_refused(capsys, option, number):
    with pytest.raises(SystemExit):
        bench(["batch", option, str(number)])
    assert f"{number} is too few" in capsys.readouterr().err


def test_the_start_is_no_part_of_a_cloud():
    found = {
        (FEW, 1): Use(1.0, 0.9),
        (108, 1): Use(11.0, 10.0),
        (FEW, 2): Use(2.0, 0.5),
        (108, 2): Use(7.0, 0.51),
    }
    text = table(found, 108, 2)
    assert "| a cloud, by the clock | 100.00 ms | 50.00 ms |" in text
    assert "| a cloud, CPU of the first process | 91.00 ms | 0.100 ms |" in text
    assert "do 2.00 times as much" in text and "spends 2.0% of a fit of 5 ms" in text
