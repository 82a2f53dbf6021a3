"""The section, the page and its pictures, from a small run of primfit and the methods that need no torch."""

from dataclasses import replace

import numpy as np
import pytest

from primfit.benchmark.command import bench
from primfit.benchmark.records import RecordsFile
from primfit.benchmark.report import pictures, write
from primfit.benchmark.report.data import Data
from primfit.benchmark.report.six import PICTURES, page, section, tables
from primfit.benchmark.report.six.ahead import comparisons
from primfit.benchmark.report.six.pictures import STUB, confusions, error_bars, named, rate_bars
from primfit.benchmark.scores import confusion, macro, rates
from primfit.fitting.names import KINDS
from primfit.synthetic.perturb import TYPES


def write_track(folder):
    """A sphere and a plane, with what M4 answered."""
    rng = np.random.default_rng(4)
    directions = rng.standard_normal((80, 3))
    plane = rng.uniform(-1.0, 1.0, (80, 3)) * [1.0, 1.0, 0.0]
    sphere = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    for number, points in enumerate((sphere, plane), 1):
        np.savetxt(folder / f"pointCloud{number}.txt", points, delimiter=",")
    (folder / "ground_truth.csv").write_text("1,3,1,0,0,0\n2,1,0,0,1,0,0,0\n")
    (folder / "m4_predictions.csv").write_text("1,3,1.125,0,0,0\n2,3,5,0,0,5\n")
    np.save(folder / "floor.npy", plane + rng.normal(0.0, 1e-3, plane.shape))
    (folder / "manifest.csv").write_text("file,kind\nfloor.npy,plane\n")


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """A clean cloud of each kind, one of a sensor, two of a track, and a real segment."""
    out, folder = tmp_path_factory.mktemp("out"), tmp_path_factory.mktemp("track")
    write_track(folder)
    methods = [argument for name in ("primfit", "m1", "m2") for argument in ("--method", name)]
    asked = ["--set", "shrec", "--shrec22", str(folder), "--real", str(folder), *methods, "--out", str(out)]
    assert bench(["run", *asked, "--n", "5"]) == 0
    assert bench(["run", "--set", "sensor", "--n", "1", *methods, "--out", str(out)]) == 0
    return Data.of(RecordsFile(out))


def rows(lines, *start):
    """The cells of table rows that begin so."""
    split = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]
    return [cells[len(start) :] for cells in split if tuple(cells[: len(start)]) == start]


def test_section_and_page_say_first_where_primfit_is_not_ahead(data):
    told = list(section(data))
    assert told[:2] == ["## The six methods", ""] and told[2].startswith("primfit is ")
    assert "ahead of m1 and m2 in TPR, TNR, PPV, NPV, ACC and L2 on A0" in told[2]
    lines = list(page(data, set(PICTURES)))
    assert lines[4 : 4 + len(told) - 4] == told[2:-2] and "benchmark-six.md" in told[-1]
    assert any("There are no records of m3, m4, m5, m6." in line for line in lines)
    heads = [line for line in lines if line.startswith("## ")]
    assert heads == [
        "## On clouds like those of the paper",
        "## On clouds of the track itself",
        "## On clouds as sensors make them",
        "## On segments of real scans",
        "## What differs from the paper",
    ]
    shown = [line for line in lines if line.startswith("![")]
    assert [line.partition("benchmark-")[2] for line in shown] == [f"{name}.png)" for name in PICTURES]
    assert "primfit bench run --set shrec --n 5 --seed 1 --method primfit --method m1 --method m2" in lines


def test_every_set_that_is_shown_is_compared(data):
    places = {one.place for one in comparisons(data)}
    assert places == {"A0", "clouds of the track", "clouds of sensors", "real segments"}


def test_the_papers_figures_stand_under_each_method(data):
    lines = tables.kinds(data, "shrec")
    assert [cells[0] for cells in rows(lines)][2:] == ["**primfit**", "m1", "M1 (paper)", "m2", "M2 (paper)"]
    m1 = data.of_set("shrec", "m1")
    ours = [f"{macro(values):.4f}" for values in rates(confusion(m1)).values()]
    assert rows(lines, "m1")[0][:6] == ["5", *ours] and rows(lines, "m1")[0][6] != "–"
    assert rows(lines, "M1 (paper)") == [["925", "0.9241", "0.9801", "0.9189", "0.9797", "0.9676", "–"]]
    lines = list(tables.errors(data, "shrec"))
    assert rows(lines, "L2", "M2 (paper)") == [["9.0e-10", "5.2e-03", "9.3e-02", "1.2e+11", "2.8e+12"]]
    assert not rows(lines, "L2", "*truth*") and len(rows(lines, "MFE, sampled surface", "*truth*")) == 1
    errors = sorted(record.error("hausdorff_sampled") for record in m1)
    quartiles = [f"{errors[k]:.1e}" for k in (1, 2, 3)]
    assert rows(lines, "directed Hausdorff, sampled surface", "m1")[0][:3] == quartiles


def test_every_level_of_a_group_has_a_column(data):
    lines = tables.by_group(data, "shrec", "points")
    levels = data.levels("shrec", "points")
    assert rows(lines, "measure", "method") == [[str(level) for level in levels]]
    measures = ["clouds", "macro TPR", "L2, median", "MFE, sampled surface, median"]
    assert [cells[0] for cells in rows(lines)][2::3] == [
        *measures,
        "directed Hausdorff, sampled surface, median",
        "ms",
    ]
    (cells,) = rows(lines, "L2, median", "**primfit**")
    (counts,) = rows(lines, "clouds", "**primfit**")
    for cell, count, level in zip(cells, counts, levels, strict=True):
        mine = [r for r in data.of_set("shrec", "primfit") if r.groups["points"] == level]
        middle = sorted(record.error("l2") for record in mine)[(len(mine) - 1) // 2]
        assert cell == f"{middle:.1e}" and count == str(len(mine))


def test_published_answers_stand_beside(data):
    lines = list(page(data, ()))
    assert rows(tables.kinds(data, "shrec22"), "m4-published")[0][0] == "2"
    clouds = tables.by_cloud(data, "shrec22")
    assert rows(clouds, "1", "sphere")[0][-1] == "1.2e-01" and rows(clouds, "2", "plane")[0][-1] == "wrong"
    assert any("*m4-published* are the answers" in line for line in lines)
    without = data.only(["primfit", "m1"])
    lines = list(page(without, ()))
    assert not any("m4-published" in line for line in lines) and "## On clouds of the track itself" in lines
    assert rows(tables.by_cloud(without, "shrec22"), "cloud", "truth", "perturbation") == [
        ["**primfit**", "m1"]
    ]


def test_of_real_segments_only_the_kind_is_known(data):
    lines = list(tables.errors(data, "real"))
    assert {cells[0] for cells in rows(lines)[2:]} == {"MFE", "directed Hausdorff"}
    assert rows(tables.kinds(data, "real"), "**primfit**")[0][:4] == ["1", "1.0000", "1.0000", "1.0000"]
    assert "parameter error" in {cells[0] for cells in rows(tables.errors(data, "sensor"))}


def test_there_is_none_without_these_methods(data):
    for names in (("primfit",), ("primfit", "m4-published")):
        few = data.only(names)
        assert list(section(few)) == []
    assert not any(picture(data.only(["primfit"])) for picture in PICTURES.values())


def test_it_can_be_read_with_one_of_them_alone(data):
    lines = list(page(data.only(["m2"]), set(PICTURES)))
    assert lines[4].startswith("Where primfit is not ahead is not known")
    assert rows(lines, "m2") and not rows(lines, "m1")
    assert all(picture(data.only(["m2"])) for picture in PICTURES.values())


def test_the_pictures_show_the_records(data, tmp_path):
    assert pictures.draw(data, tmp_path, PICTURES) == set(PICTURES)
    for name in PICTURES:
        assert (tmp_path / f"benchmark-{name}.png").read_bytes().startswith(b"\x89PNG")
    for number, method in enumerate(("primfit", "m1", "m2")):
        axes = confusions("shrec")(data).axes[number]
        counts = confusion(data.of_set("shrec", method))
        texts = [text.get_text() for text in axes.texts]
        assert axes.get_title(loc="left") == method
        assert sum(int(text or 0) for text in texts) == len(KINDS)
        assert texts[: len(KINDS)] == [str(n or "") for n in counts[0, : len(KINDS)].tolist()]


def test_bars_are_as_high_as_the_figures(data):
    titles = [axes.get_title(loc="left") for axes in rate_bars(data).axes]
    assert titles == ["PPV", "NPV", "TPR", "TNR", "ACC"]
    bars = [bar.get_height() for bar in rate_bars(data).axes[titles.index("TPR")].patches]
    found = [rates(confusion(data.of_set("shrec", method)))["TPR"] for method in ("primfit", "m1", "m2")]
    assert bars == pytest.approx([macro(values) for values in found])
    moved = [replace(r, groups={"perturbation": "A1"}) if r.method == "m2" else r for r in data.records]
    figure = error_bars(Data(moved, data.about))
    heights = np.array([bar.get_height() for bar in figure.axes[0].patches]).reshape(2, 3)
    assert np.isnan(heights).tolist() == [[False, False, True], [True, True, False]]
    assert heights[0, 0] == STUB  # clean clouds are found exactly
    means = [r.error("l2") for r in data.of_set("shrec", "m1") if r.right]
    assert heights[0, 1] == pytest.approx(max(np.mean(means), STUB))
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["A0 clean", "A1 uniform noise"]


def test_every_perturbation_has_words():
    words = [named(level) for level in TYPES]
    assert len(set(words)) == len(TYPES) and words[8:] == ["Gaussian noise + missing part", "deformation"]
    assert named("unknown") == ""


def test_the_pages_are_written_beside_the_report(data, tmp_path):
    file = RecordsFile(tmp_path / "records")
    file.rewrite(data.records)
    file.describe(data.about)
    write(file, tmp_path)
    six, main = ((tmp_path / name).read_text() for name in ("benchmark-six.md", "benchmark.md"))
    heading = "## What differs from the paper"
    assert heading in six and heading not in main and "(benchmark-six.md)" in main
    assert "| TPR | m1 |" in (tmp_path / "benchmark-six-details.md").read_text()
    assert "| TPR | m1 |" not in (tmp_path / "benchmark-details.md").read_text()
