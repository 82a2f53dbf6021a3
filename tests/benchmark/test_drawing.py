"""`primfit bench drawing`: how many clouds of each recipe are drawn in a minute."""

from primfit.benchmark.command import bench
from primfit.benchmark.drawing import BARS, Rate, rate, table
from primfit.synthetic import RECIPES


def test_clouds_are_drawn_until_the_time_is_over():
    drawn = rate("benchmark", 3, 0.05)
    assert drawn.clouds >= 1 and drawn.points >= drawn.clouds and drawn.seconds >= 0.05
    assert rate("foreign", 3, 1e-9).clouds == 1


def test_the_table_holds_rates_against_their_bars():
    limit = BARS["scanner"]
    fast = Rate("scanner", limit, 7000 * limit, 60.0)
    assert f"| `scanner` | {limit:,} | 7,000 | {limit:,}: met |" in table([fast])
    assert "missed" in table([Rate("scanner", limit - 1, 1, 60.0)])
    assert table([Rate("foreign", 3, 30, 2.0)]).splitlines()[-1] == "| `foreign` | 90 | 10 |  |"


def test_the_command_measures_every_recipe(capsys, monkeypatch):
    monkeypatch.setattr(
        "primfit.benchmark.drawing.rate", lambda name, seed, seconds: Rate(name, seed, 700, seconds)
    )
    assert bench(["drawing", "--seed", "7", "--seconds", "2"]) == 0
    lines = capsys.readouterr().out.splitlines()[2:]
    assert [line.split("`")[1] for line in lines] == list(RECIPES) and set(BARS) <= set(RECIPES)
    assert "| 210 | 100 |" in lines[0]
