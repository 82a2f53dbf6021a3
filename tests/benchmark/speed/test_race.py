"""`primfit bench speed`: a short race with what is installed, its tables from made times, and the page."""

import sys
from pathlib import Path

import numpy as np
import pytest

from primfit.benchmark.command import bench
from primfit.benchmark.records import Outcome
from primfit.benchmark.speed import page, race
from primfit.benchmark.speed.page import PageError
from primfit.benchmark.speed.race import OURS, REVERSED, Lap, Race, exponent
from primfit.fitting.geometry.vectors import unit
from primfit.synthetic.recipes import KINDS


def answered(seconds, normals=0.0, status="fitted"):
    return Outcome(status, cpu_seconds=seconds, normals_seconds=normals)


def made():
    """Three clouds: engeom is not asked about the torus, and fails on one of the others."""
    laps = [
        Lap("shrec", "plane", 1000, {OURS: answered(0.01), "engeom": answered(0.03)}),
        Lap("shrec", "cylinder", 2000, {OURS: answered(0.02), "engeom": answered(0.04, 0.03)}),
        Lap("scanner", "cone", 2000, {OURS: answered(0.03), "engeom": answered(0.01, status="error")}),
        Lap("scanner", "torus", 4000, {OURS: answered(0.05)}),
    ]
    versions = {OURS: "1", "engeom": "2"}
    return Race(laps, {1000: 5.0, 10_000: 50.0}, "a machine", versions, {"cgal": "No module named 'CGAL'"})


def test_times_are_compared_on_the_clouds_that_both_answered():
    lines = race.section(made()).splitlines()
    assert lines[0] == (
        "4 clouds (2 of `shrec`, 2 of `scanner`); a machine, one thread; primfit 1, engeom 2. "
        "cgal is not installed."
    )
    assert "| primfit | 4 | 25.0 ms | 47.0 ms | 1.00 | 1.00 | – | 0 |" in lines
    # ratio of medians 35 / 15, median of the ratios 3 and 2; without normals 30 and 10 ms
    assert "| engeom, kind given | 2 | 35.0 ms | 39.5 ms | 2.33 | 2.50 | 20.0 ms, ratio 1.33 | 1 |" in lines


def test_times_are_shown_by_set_and_kind_and_grow_with_the_points():
    text = race.section(made())
    assert "| shrec | 2 | 1,500 | 15.0 ms | 35.0 ms | 19.5 ms |" in text
    assert "| torus | 1 | 4,000 | 50.0 ms | – | 50.0 ms |" in text and "| sphere |" not in text
    assert "| all but tori | 3 | 2,000 | 20.0 ms | 35.0 ms | 29.0 ms |" in text
    assert "A torus takes primfit 2.50 times as long as the others" in text
    assert "| 10,000 | 50.0 ms | 1.00 |" in text and "as the 1.00th power" in text


@pytest.mark.parametrize("power", [0.5, 1.0, 1.3])
def test_the_exponent_is_that_of_a_power_law(power):
    assert exponent({n: 0.1 * n**power for n in (10, 100, 1000)}) == pytest.approx(power)


def test_methods_that_answer_nothing_have_no_figures():
    empty = Race(
        [Lap("shrec", "plane", 9, {OURS: answered(None, status="timeout")})], {}, "m", {OURS: "1"}, {}
    )
    assert "| primfit | 0 | – | – | – | – | – | 1 |" in race.section(empty)


def test_a_short_race(tmp_path, monkeypatch, capsys):
    pages = tmp_path / "performance.md"
    pages.write_text("".join(page.lines_about("speed")))
    monkeypatch.setattr(page.write, "__defaults__", (pages,))
    monkeypatch.setattr(race, "KINDS", ("sphere",))
    segments = tmp_path / "segments"
    segments.mkdir()
    rng = np.random.default_rng(0)
    np.save(segments / "ball.npy", np.array([unit(each) for each in rng.normal(size=(60, 3))]))
    (segments / "manifest.csv").write_text("file,kind\nball.npy,sphere\n")
    options = ["--n", "1", "--seed", "7", "--real", str(segments), "--largest", "1000"]
    assert bench(["speed", *options, "--out", str(tmp_path), "--python", sys.executable, "--write"]) == 0
    text = pages.read_text()
    assert "4 clouds (1 of `shrec`, 1 of `scanner`, 1 of `sensor`, 1 of `real`)" in text
    assert "| primfit | 4 | " in text and "| primfit, ranking reversed | 4 | " in text
    assert "`primfit bench speed --n 1 --seed 7 --real DIR`" in text
    assert "written:" in capsys.readouterr().out and (tmp_path / "methods.log").exists()


def test_a_reversed_ranking_tries_the_true_kind_last(tmp_path):
    from primfit.benchmark.cases import CASE_SETS

    with race.Child(Path(sys.executable), tmp_path / "log", race.PROGRAM) as child:
        case = CASE_SETS["shrec"].draw(7, KINDS.index("sphere"))
        ours, turned = (child.fit(name, case, None, 60.0) for name in (OURS, REVERSED))
    assert ours.status == turned.status == "fitted" and ours.primitive["kind"] == case.kind
    assert ours.attempts[0] == turned.attempts[-1] == case.kind


def test_a_page_without_the_lines_of_a_part_is_named(tmp_path):
    begin, end = page.lines_about("speed")
    for text in ("", begin, f"{end}{begin}"):
        (tmp_path / "page.md").write_text(text)
        with pytest.raises(PageError, match=r"page\.md has no lines `<!-- speed: written by"):
            page.write("speed", "text", "command", tmp_path / "page.md")


def test_the_page_of_the_repository_has_both_parts():
    text = page.PAGE.read_text()
    for part in ("steps", "speed"):
        begin, end = page.lines_about(part)
        assert 0 < text.index(begin) < text.index(end)
