"""`primfit bench steps`: that steps add up, what floors depend on, figures that are kept, and the tables."""

import json

import pytest

from primfit.benchmark.command import bench
from primfit.benchmark.speed import page as page_module
from primfit.benchmark.speed import steps
from primfit.benchmark.speed.ceilings import Ceilings
from primfit.benchmark.speed.floor import FLOORS
from primfit.benchmark.speed.steps import KEPT, WHOLE, Family, Measured, Timed
from primfit.benchmark.speed.table import REST, STEPS
from primfit.synthetic.recipes import KINDS

BEST = Ceilings(48e9, 1e9, 1e9, 2e9, 3e10, 1e9, 2e7, 2e6)


def made(milliseconds=1.0, loop=2.0, slow=()):
    """A run in which each step takes so long, some of them half as long again."""
    spent = {step: milliseconds * (1.5 if step in slow else 1.0) for step in (*STEPS, REST)}
    spent[WHOLE] = sum(spent.values())
    floor = {step: 0.1 for step in STEPS} | {"verdict": 1e-5, WHOLE: 1.5}
    clouds = [Timed(kind, 2700 + index, 2, spent, floor) for index, kind in enumerate(KINDS)]
    return Measured("a machine", loop, BEST, [Family(name, clouds) for name in steps.FAMILIES])


@pytest.fixture(scope="module")
def measured():
    """A real run, of a cloud of each kind of scans that are quick to draw."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(steps, "DRAWN", 5)
        patch.setattr(steps, "REPEATS", 1)
        return steps.measure(1, 7)


def test_steps_add_up_to_what_an_answer_takes(measured):
    for family in measured.families:
        assert [cloud.kind for cloud in family.clouds] == list(KINDS)
        for cloud in family.clouds:
            assert set(cloud.spent) - {WHOLE} <= {*STEPS, REST}
            assert cloud.spent[REST] > 0.0 and cloud.spent["normals"] > 0.0
            assert cloud.floor[WHOLE] == pytest.approx(sum(cloud.floor[step] for step in FLOORS))


def test_the_tables_have_every_step(measured):
    text = steps.section(measured)
    for step in STEPS:
        assert text.count(f"\n| {step} | ") == len(steps.FAMILIES)
    assert text.count("| **whole answer** |") == len(steps.FAMILIES) and "billion" in text


def test_figures_are_means_over_kinds_of_medians_over_clouds():
    clouds = [
        Timed(kind, 100, 1, {"read": value}, {"read": 0.5})
        for kind, value in (("plane", 1.0), ("plane", 2.0), ("plane", 30.0), ("torus", 6.0))
    ]
    family = Family("shrec", clouds)
    assert family.spent("read") == 4.0 and family.floor("read") == 0.5 and family.spent("rank") == 0.0


def test_the_tables_say_how_far_a_step_is_from_its_floor():
    lines = steps.section(made()).splitlines()
    assert "| normals | 1.000 ms | 6% | 100 µs | 10.0 |" in lines
    assert "| verdict | 1.000 ms | 6% | 0 µs | over 1,000 |" in lines
    assert f"| {REST} | 1.000 ms | 6% | – | – |" in lines


def test_what_floors_depend_on_is_read_from_the_answer():
    tried = {"kind": "cone", "primitive": {"kind": "cone"}}
    answer = {
        "attempts": [tried, {"kind": "torus", "primitive": None}],
        "primitive": {"kind": "cone"},
        "alternatives": [{"kind": "ellipsoid"}],  # a kind that nobody has counted
        "noise": {"exact_share": 0.25},
    }
    body = json.dumps(answer).encode()
    facts = steps.facts_of(50, body, {"rivals": 3, "starts": 2})
    assert (facts.tried, facts.answered) == (("cone",), ("cone", "torus"))
    assert facts.exact and not facts.spared and facts.rivals == 3 and facts.answer_bytes == len(body)
    nothing = answer | {"primitive": None, "alternatives": [], "noise": None}
    bare = steps.facts_of(50, json.dumps(nothing).encode(), {})
    assert bare.answered == () and bare.spared and bare.rivals == 0


def test_slower_steps_are_found_whatever_the_speed_of_the_machine(tmp_path):
    path = tmp_path / "kept.json"
    steps.keep(made(), path)
    assert steps.slower(made(), path) == []
    assert steps.slower(made(milliseconds=3.0, loop=6.0), path) == []
    (first, second) = steps.slower(made(slow=("rank",)), path)
    assert first.startswith("shrec, rank: 1.50 times") and second.startswith("scanner, rank: 1.50 times")
    everything = steps.slower(made(milliseconds=1.5), path)
    assert len(everything) == len(steps.FAMILIES) * (len(STEPS) + 2)


def test_a_step_that_hardly_counts_or_is_new_is_not_slower(tmp_path):
    path = tmp_path / "kept.json"
    steps.keep(made(), path)
    held = json.loads(path.read_text())
    for family in held["loops"].values():
        del family["rank"]
        family["normals"] = 0.2
        family[WHOLE] = 1000.0
    path.write_text(json.dumps(held))
    assert steps.slower(made(), path) == []


def test_kept_figures_are_of_the_steps_of_the_table():
    kept = json.loads(KEPT.read_text())["loops"]
    assert list(kept) == list(steps.FAMILIES)
    for family in kept.values():
        assert set(family) == {*STEPS, REST, WHOLE}


def test_the_command_prints_keeps_compares_and_writes(tmp_path, monkeypatch, capsys):
    kept, page = tmp_path / "kept.json", tmp_path / "performance.md"
    begin, end = page_module.lines_about("steps")
    page.write_text(f"before\n{begin}old\n{end}after\n")
    runs = iter([made(), made(slow=("rank",)), made()])
    monkeypatch.setattr(steps, "measure", lambda n, seed: next(runs))
    monkeypatch.setattr(steps, "KEPT", kept)
    monkeypatch.setattr(steps.keep, "__defaults__", (kept,))
    monkeypatch.setattr(steps.slower, "__defaults__", (kept,))
    monkeypatch.setattr(page_module, "PAGE", page)
    monkeypatch.setattr(page_module.write, "__defaults__", (page,))
    assert bench(["steps", "--keep"]) == 0 and kept.exists()
    assert "| normals | 1.000 ms |" in capsys.readouterr().out
    assert bench(["steps", "--compare"]) == 1
    assert "shrec, rank: 1.50 times what was kept" in capsys.readouterr().out
    assert bench(["steps", "--compare", "--write", "--n", "2"]) == 0
    assert "no step takes more than 1.25 times" in capsys.readouterr().out
    text = page.read_text()
    assert text.startswith(f"before\n{begin}") and text.endswith(f"{end}after\n") and "old" not in text
    assert "`primfit bench steps --n 2 --seed 1`" in text
