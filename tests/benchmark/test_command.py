"""`primfit bench`: a run of every set that is cut off, goes on, and is repeated; its report; its errors."""

import json
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from primfit.app.cli import commands as cli
from primfit.benchmark import command, options
from primfit.benchmark.cases import CASE_SETS
from primfit.benchmark.command import BAD_INPUT, INTERRUPTED, bench
from primfit.benchmark.records import TIMES, RecordsFile
from primfit.benchmark.report import pictures
from primfit.models.weights import load
from tests.paths import ROOT


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The records of two clouds of every set and both of a folder."""
    out = tmp_path_factory.mktemp("bench")
    track = tmp_path_factory.mktemp("track")
    (track / "pointCloud1.txt").write_text("".join(f"{i % 7},{i % 5},0\n" for i in range(35)))
    (track / "ground_truth.csv").write_text("1,1,0,0,1,0,0,0\n")
    sets = [argument for name in CASE_SETS for argument in ("--set", name)]
    assert bench(["run", *sets, "--shrec22", str(track), "--n", "2", "--out", str(out)]) == 0
    return out


def timeless(records):
    return [replace(record, **dict.fromkeys(TIMES)) for record in records]


def test_a_run_stores_a_record_for_each_cloud(folder):
    records = list(RecordsFile(folder).read())
    assert [record.set for record in records] == [*(name for name in CASE_SETS for _ in range(2)), "shrec22"]
    for record in records:
        assert record.method == "primfit" and record.versions["primfit"] and record.versions["source"]
        assert record.seconds > 0.0 and record.attempts and record.note
    hard = ("foreign", "ambiguity", "bows", "cone-arcs", "sections", "sensor")
    right = [record.right for record in records if record.set not in hard]
    assert sum(right) >= len(right) - 1


def test_a_run_goes_on_and_the_same_seed_gives_the_same_records_but_for_time(folder, tmp_path, capsys):
    arguments = ["run", "--set", "shrec", "--set", "scanner", "--n", "2", "--out", str(tmp_path)]
    first = [record for record in RecordsFile(folder).read() if record.set in ("shrec", "scanner")]
    lines = (folder / "records.jsonl").read_text().splitlines(keepends=True)
    (tmp_path / "records.jsonl").write_text("".join(lines[:2]) + lines[2][:50])
    assert bench(arguments) == 0
    shown = capsys.readouterr().out
    assert "2/2" in shown and "primfit: 2 of 2 right" in shown and "records: " in shown
    gone_on = list(RecordsFile(tmp_path).read())
    assert gone_on[:2] == first[:2] and timeless(gone_on) == timeless(first)

    assert bench([*arguments, "--restart"]) == 0
    again = list(RecordsFile(tmp_path).read())
    assert timeless(again) == timeless(first)
    assert [record.seconds for record in again[:2]] != [record.seconds for record in first[:2]]


def test_the_report_is_made_of_the_records(folder, tmp_path, capsys):
    assert bench(["report", "--records", str(folder), "--out", str(tmp_path)]) == 0
    assert "benchmark.md" in capsys.readouterr().out
    text = (tmp_path / "benchmark.md").read_text()
    for chosen in CASE_SETS.values():
        assert f"\n## {chosen.description.title}\n" in text
    assert text.index("## What the estimator is held to") < text.index("## At a glance")
    assert "primfit bench run --set arcs --n 2 --seed 1\n" in text
    assert "primfit bench run --shrec22 DIR\n" in text
    for name in pictures.PICTURES:
        assert (tmp_path / "images" / f"benchmark-{name}.png").read_bytes().startswith(b"\x89PNG")
        assert f"(images/benchmark-{name}.png)" in text
    assert "M4 (paper)" in (tmp_path / "benchmark-details.md").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--n", "0"], "argument --n: is 0, not a whole number from 1 on"),
        (["--n", "many"], "argument --n: is many, not a whole number from 1 on"),
        (["--seed", "-1"], "argument --seed: is -1, not a whole number from 0 on"),
        (
            ["--seed", "2023"],
            "argument --seed: is 2023; what is measured has seen clouds of the seeds",
        ),
        (["--timeout", "0"], "argument --timeout: is 0, not a number of seconds above 0 and up to 86400"),
        (["--set", "cubes"], "argument --set: invalid choice: 'cubes'"),
        (["--python", "/nowhere"], "argument --python: is /nowhere, which is no file"),
        (["--n", "3", "--full"], "argument --full: not allowed with argument --n"),
    ],
)
def test_options_out_of_range_are_named(arguments, message, capsys):
    with pytest.raises(SystemExit) as exit:
        bench(["run", *arguments])
    assert exit.value.code == BAD_INPUT
    assert message in capsys.readouterr().err


def test_what_cannot_be_done_is_said(tmp_path, capsys, monkeypatch):
    def complaint(*arguments: str) -> str:
        assert bench(list(arguments)) == BAD_INPUT
        return capsys.readouterr().err

    out = str(tmp_path / "out")
    assert "holds no pointCloud1.txt" in complaint("run", "--shrec22", str(tmp_path), "--out", out)
    assert "holds no records: run `primfit bench run` first" in complaint("report", "--records", out)
    monkeypatch.setattr(pictures, "find_spec", lambda name: None)
    assert "need matplotlib: pip install" in complaint("report", "--records", out)
    assert bench([]) == BAD_INPUT


def test_methods_that_are_not_installed(tmp_path, capsys):
    known = {"primfit": {"kinds": []}, "cgal": {"missing": "No module named 'CGAL'"}}

    class Console:
        said: list[str] = []  # noqa: RUF012

        def print(self, text):
            self.said.append(text)

    assert set(command.usable(known, ["primfit"], Console())) == {"primfit"}
    assert Console.said == [
        "left out: cgal is not installed (No module named 'CGAL'); `make bench-peers` installs the peers"
    ]
    with pytest.raises(command.MethodError, match="cgal is not installed"):
        command.usable(known, ["cgal"], Console())


def test_an_interrupted_run_says_how_to_go_on(tmp_path, capsys, monkeypatch):
    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "introduce", interrupted)
    assert bench(["run", "--out", str(tmp_path)]) == INTERRUPTED
    assert f"interrupted; the same command goes on from {tmp_path}" in capsys.readouterr().err


def test_the_command_line_passes_everything_on():
    shown = CliRunner().invoke(cli.app, ["bench", "--help"])
    assert shown.exit_code == 0 and "primfit bench run --full --peers" in shown.output
    shown = CliRunner().invoke(cli.app, ["bench", "run", "--help"])
    assert all(name in shown.output for name in (*CASE_SETS, "scikit-spatial"))
    assert CliRunner().invoke(cli.app, ["bench", "run", "--n", "0"]).exit_code == BAD_INPUT


def test_seeds_that_the_classifiers_learnt_from_are_known():
    for name in ("network", "knn"):
        card = json.loads((ROOT / "models" / "weights" / f"{name}.json").read_text())
        seeds = {value for key, value in [*card.items(), *card["recipe"].items()] if key.endswith("seed")}
        assert seeds and seeds <= set(options.LEARNT)
        load(name)
