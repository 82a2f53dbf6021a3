"""`primfit synth`: what it writes is read back bit by bit, by the readers of the benchmark."""

import csv
import typing
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from primfit.app.cli import commands as cli
from primfit.app.cli.status import BAD_INPUT
from primfit.benchmark.track import TrackError, TrackFolder, shrec22_cases
from primfit.synthetic import RECIPES, clouds, picture
from primfit.synthetic.command import UnknownRecipeError, synth
from primfit.synthetic.recipes import RECIPES as KNOWN


@pytest.mark.parametrize("recipe", ["benchmark", "scanner", "sensor"])
def test_clouds_and_truth_are_read_back_as_they_were(recipe, tmp_path):
    synth(recipe, tmp_path, n=6, seed=3, picture=False)
    cases = list(shrec22_cases(tmp_path))
    assert [case.name for case in cases] == ["1", "2", "3", "4", "5", "6"]
    for case, cloud in zip(cases, clouds(replace(RECIPES[recipe], seed=3), 6), strict=True):
        assert np.array_equal(case.points, cloud.points)
        assert case.truth.kind == cloud.kind
        for name in ("radius", "half_angle", "major_radius", "point", "apex", "center"):
            assert np.array_equal(getattr(case.truth, name, None), getattr(cloud.primitive, name, None))


def test_foreign_shapes_have_attributes_but_no_truth(tmp_path):
    synth("foreign", tmp_path, n=7, seed=0, picture=False)
    with pytest.raises(TrackError, match=r"holds 7 clouds, but no ground_truth.csv"):
        TrackFolder(tmp_path)
    with (tmp_path / "attributes.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["kind"] for row in rows][:2] == ["ellipsoid", "corner"]
    for row in rows:
        points = np.loadtxt(tmp_path / "clouds" / f"pointCloud{row['i']}.txt", delimiter=",")
        assert len(points) == int(row["n_points"])
        assert float(row["noise"]) > 0.0 and row["arc"] == ""


def test_of_sensors_the_effects_are_written(tmp_path):
    synth("sensor", tmp_path, n=5, seed=2, picture=False)
    with (tmp_path / "attributes.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    for row, cloud in zip(rows, clouds(replace(RECIPES["sensor"], seed=2), 5), strict=True):
        effects = dict(effect.split("=") for effect in row["effects"].split("; "))
        assert row["sensor"] == cloud.sensor and set(effects) == set(cloud.effects)
        assert float(effects["white"]) == pytest.approx(cloud.effects["white"], rel=1e-5)


def test_the_picture_shows_a_sample(tmp_path):
    result = CliRunner().invoke(
        cli.app, ["synth", "scanner", "--n", "3", "--seed", "1", "--out", str(tmp_path)]
    )
    assert result.exit_code == 0, result.output
    assert result.output.startswith("3 clouds of the recipe scanner, seed 1")
    assert (tmp_path / "sample.png").read_bytes().startswith(b"\x89PNG")


def test_without_matplotlib_the_picture_is_left_out_with_a_hint(tmp_path, monkeypatch):
    monkeypatch.setattr(picture, "find_spec", lambda name: None)
    result = CliRunner().invoke(cli.app, ["synth", "benchmark", "--n", "2", "--out", str(tmp_path)])
    assert result.exit_code == 0
    assert "no picture, which needs matplotlib: pip install" in result.stdout
    assert (tmp_path / "attributes.csv").exists() and not (tmp_path / "sample.png").exists()


def test_without_matplotlib_a_picture_that_was_asked_for_is_refused_before_anything_is_written(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(picture, "find_spec", lambda name: None)
    out = tmp_path / "clouds"
    arguments = ["synth", "benchmark", "--n", "2", "--out", str(out)]
    result = CliRunner().invoke(cli.app, [*arguments, "--picture"])
    assert result.exit_code == BAD_INPUT
    assert "needs matplotlib: pip install" in result.stderr
    assert not out.exists()
    assert CliRunner().invoke(cli.app, [*arguments, "--no-picture"]).exit_code == 0


def test_unknown_recipes_are_refused(tmp_path):
    assert CliRunner().invoke(cli.app, ["synth", "cube", "--out", str(tmp_path)]).exit_code == BAD_INPUT
    with pytest.raises(UnknownRecipeError, match="benchmark, scanner"):
        synth("cube", tmp_path)


def test_the_command_line_offers_every_recipe():
    recipe = typing.get_type_hints(cli.synth)["recipe"]
    assert typing.get_args(recipe) == tuple(KNOWN)
