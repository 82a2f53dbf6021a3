"""`primfit bench service`: a real service beside the fit alone, the table, and the picture."""

import numpy as np
import pytest

from primfit.benchmark import service
from primfit.benchmark.command import bench
from primfit.benchmark.service import Row, Times, livez_line, table
from primfit.benchmark.serving import CLIENTS, bare, plain, serving


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(service, "BAR", ("npy", 100, 2.0))
    monkeypatch.setattr(service, "LIVEZ", (20_000, 100.0))
    monkeypatch.setattr(service, "IN_A_ROW", 2)


FITS = np.full((1, 3), 10.0)


def row(format="npy", points=3000, added=1.0, fits=FITS):
    """Requests take `added` milliseconds more than fits, those of the plain client 0.25 more than that."""
    alone = Times(fits, fits[:, :1])
    requests = {
        client: Times(fits + added + more, fits[:, :1] + 0.5)
        for client, more in zip(CLIENTS, (0.0, 0.25), strict=True)
    }
    return Row(format, points, 72_000, alone, requests)


@pytest.mark.slow
def test_requests_are_measured_beside_the_fit_alone(small, tmp_path, capsys):
    assert bench(["service", "--turns", "1", "--points", "100", "--out", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split("|")[2].strip() for line in lines[2:6]] == list(service.BODIES)
    assert "Bar: a request of 100 points as npy" in lines[7]
    assert "Bar: `GET /livez` takes at most 100 ms while 20,000 points" in lines[9]
    assert (tmp_path / "service.log").stat().st_size > 0


def test_sizes_and_formats_can_be_chosen_and_both_clients_get_the_same_answer(small, tmp_path, monkeypatch):
    monkeypatch.setattr(service, "KINDS", ("sphere", "plane"))
    monkeypatch.setattr(service, "LARGE", 150)
    rows = list(service.measure(2, 1, tmp_path / "log", (100, 200), ("base64",)))
    assert [(row.format, row.points) for row in rows] == [("base64", 100), ("base64", 200)]
    for measured, turns in zip(rows, (2, 1), strict=True):  # a large cloud has one turn
        for times in (measured.fits, *(measured.requests[client] for client in CLIENTS)):
            assert times.wall.shape == times.cpu.shape == (2, turns)
            assert (times.wall > 0.0).all() and (times.cpu > 0.0).all()


def test_a_refusal_is_no_figure(tmp_path):
    with serving(tmp_path / "log") as served:
        for client in (bare, plain):
            with client(served.port) as ask, pytest.raises(service.ServiceError, match="answered 422"):
                ask("text/csv", b"x,y,z\n1,2,3\n")


def test_another_answer_than_that_of_the_fit_alone_is_no_figure(small, tmp_path, capsys, monkeypatch):
    media_type, _ = service.BODIES["csv"]
    monkeypatch.setitem(service.BODIES, "csv", (media_type, lambda points: service.csv(2.0 * points)))
    assert (
        bench(["service", "--turns", "1", "--points", "100", "--format", "csv", "--out", str(tmp_path)]) == 2
    )
    assert "answer differently: csv" in capsys.readouterr().err


def test_the_table_has_medians_and_what_the_fastest_differ_by():
    fits = np.array([[10.0, 11.0, 30.0]])
    text = table([row(added=np.array([1.5, 1.0, 5.0]), fits=fits)])
    assert "| 3,000 | npy | 72.0 kB | 11.00 ms | 12.00 ms | 1.50 ms |" in text
    assert text.splitlines()[2].endswith("| 1.50 ms | 1.75 ms | 0.50 ms |")
    assert "1.50 ms, met." in text
    assert "missed." in table([row(added=2.1)])
    assert "Bar" not in table([row(points=1000)])
    assert "12.0 ms, met." in livez_line(12.0) and "120.0 ms, missed." in livez_line(120.0)


def test_a_system_that_tells_no_times_of_processes_leaves_their_column_empty():
    unknown = {client: Times(np.full((1, 3), 11.0), np.full((1, 1), np.nan)) for client in CLIENTS}
    measured = Row("npy", 1000, 24_000, row().fits, unknown)
    assert table([measured]).endswith("| 1.00 ms | – |")


def test_the_picture_is_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    from primfit.benchmark.report.added import draw_added

    rows = [row(name, size) for name in service.BODIES for size in service.SIZES]
    draw_added(rows, tmp_path / "added.png")
    assert (tmp_path / "added.png").read_bytes().startswith(b"\x89PNG")
