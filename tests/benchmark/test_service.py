"""`primfit bench service`: a real service beside the fit alone, the table, and the picture."""

import numpy as np
import pytest

from primfit.benchmark import service
from primfit.benchmark.command import bench
from primfit.benchmark.service import Row, livez_line, table


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(service, "SIZES", (100,))
    monkeypatch.setattr(service, "BAR", ("npy", 100, 2.0))
    monkeypatch.setattr(service, "LIVEZ", (20_000, 100.0))
    monkeypatch.setattr(service, "IN_A_ROW", 2)


@pytest.mark.slow
def test_requests_are_measured_beside_the_fit_alone(small, tmp_path, capsys):
    assert bench(["service", "--turns", "1", "--out", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split("|")[2].strip() for line in lines[2:5]] == list(service.FORMATS)
    assert "Bar: a request of 100 points as npy" in lines[6]
    assert "Bar: `GET /livez` takes at most 100 ms while 20,000 points" in lines[7]
    assert (tmp_path / "service.log").stat().st_size > 0


def test_another_answer_than_that_of_the_fit_alone_is_no_figure(small, tmp_path, capsys, monkeypatch):
    media_type, _ = service.FORMATS["csv"]
    monkeypatch.setitem(service.FORMATS, "csv", (media_type, lambda points: service.csv(2.0 * points)))
    assert bench(["service", "--turns", "1", "--out", str(tmp_path)]) == 2
    assert "answer differently: csv" in capsys.readouterr().err


def test_the_table_has_medians_and_what_the_fastest_differ_by():
    fits = np.array([[10.0, 11.0, 30.0]])
    rows = [Row("npy", 3000, 72_000, fits + np.array([1.5, 1.0, 5.0]), fits)]
    text = table(rows)
    assert "| 3,000 | npy | 72.0 kB | 11.00 ms | 12.00 ms | 1.50 ms |" in text and "| 1.50 ms |" in text
    assert "1.50 ms, met." in text
    assert "missed." in table([Row("npy", 3000, 72_000, fits + 2.1, fits)])
    assert "12.0 ms, met." in livez_line(12.0) and "120.0 ms, missed." in livez_line(120.0)


def test_the_picture_is_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    from primfit.benchmark.report.added import draw_added

    fits = np.full((1, 3), 10.0)
    rows = [Row(name, size, 1, fits + 1.0, fits) for name in service.FORMATS for size in service.SIZES]
    draw_added(rows, tmp_path / "added.png")
    assert (tmp_path / "added.png").read_bytes().startswith(b"\x89PNG")
