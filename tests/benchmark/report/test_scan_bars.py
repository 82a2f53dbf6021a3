"""Bars of real segments, sensors' clouds, bows, arcs of cones and sections, from records that are made up."""

from dataclasses import replace

import pytest

from primfit.benchmark.real import REAL
from primfit.benchmark.records import Record
from primfit.benchmark.report.scan_bars import (
    SCAN_BARS,
    SHAPE_BARS,
    each_kind,
    is_cautious,
    is_cylinder_alone,
    is_told,
    names_other,
    no_worse_with_more_points,
)
from primfit.benchmark.report.scans import SENSOR
from primfit.benchmark.scores import is_first
from tests.benchmark.made import record


def several(kind: str, *named: str, **fields: object) -> Record:
    """An `ambiguous` answer that names these kinds."""
    made = record(kind, "ambiguous", alternatives=named[1:], **fields)
    return replace(made, answer={"kind": named[0]})


def met(case: str, bar: str, records: list[Record]) -> bool | None:
    (found,) = [b for b in (*SCAN_BARS, *SHAPE_BARS) if b.case == case and b.bar.startswith(bar)]
    return found.measure([r for r in records if found.concerns(r)]).met


@pytest.mark.parametrize(
    ("bar", "good", "bad", "most_bad"),
    [
        ("at least 31", record("plane", "plane", set=REAL), record("plane", "no_fit", set=REAL), 5),
        ("at least 34", several("plane", "torus", "plane", set=REAL), record("plane", "no_fit", set=REAL), 2),
        ("other kinds", record("plane", "no_fit", set=REAL), record("plane", "cone", set=REAL), 2),
        ("`ambiguous`", record("plane", "plane", set=REAL), several("plane", "plane", set=REAL), 3),
    ],
)
def test_the_bars_of_the_36_segments(bar, good, bad, most_bad):
    def of(bad_ones: int) -> bool | None:
        return met("real segments", bar, [bad] * bad_ones + [good] * (36 - bad_ones))

    assert of(most_bad) and not of(most_bad + 1)


def test_ambiguous_without_the_truth_names_others():
    assert names_other(several("plane", "torus", "cone"))
    assert not names_other(several("plane", "torus", "plane"))
    assert not names_other(record("plane", "no_fit")) and not names_other(record("plane", "failed"))


def test_each_kind_is_looked_at():
    records = [record("plane", "plane", set=SENSOR)] * 90
    records += [record("cone", "cone", set=SENSOR)] * 7 + [record("cone", "torus", set=SENSOR)] * 1
    assert not each_kind(0.88)(records).met and each_kind(0.88)(records).text == "cone 87.5%"
    assert each_kind(0.88)([*records, records[90]]).met
    assert each_kind(0.88)([]).met is None


def test_points_make_it_no_worse():
    def made(right: int, points: str) -> list[Record]:
        answers = ["plane"] * right + ["sphere"] * (100 - right)
        return [record("plane", answer, set="bows", groups={"points": points}) for answer in answers]

    few, many = "200 to 1,000", "10,000 to 50,000"
    # Two standard errors of 95 of 100 against 88 and 86 of 100: 7.8 and 8.2 %.
    assert no_worse_with_more_points([*made(95, few), *made(88, many)]).met
    assert not no_worse_with_more_points([*made(95, few), *made(86, many)]).met
    assert no_worse_with_more_points([*made(95, few), *made(100, many)]).text == "95.0%, –, 100%"
    assert no_worse_with_more_points(made(95, few)).met is None


def test_a_large_bow_may_be_followed():
    for kind, answer, told in (
        ("plane", "plane", True),
        ("plane", "sphere", True),
        ("cylinder", "torus", True),
        ("cone", "torus", False),
        ("sphere", "cylinder", False),
        ("torus", "no_fit", False),
        ("torus", "ambiguous", True),
        ("torus", "failed", False),
    ):
        assert is_told(record(kind, answer)) is told, (kind, answer)


def test_amplitudes_are_looked_at_apart():
    small, large = ({"amplitude [noise]": level} for level in (1.0, 3.0))
    records = [record("plane", "plane", set="bows", groups=small)]
    records += [record("plane", "no_fit", set="bows", groups=large)]
    assert met("bows, lobes, barrels of up to 1 noise scale", "at least", records)
    assert not met("bows, lobes, barrels of 3 noise scales", "right", records)


def test_cones_and_cylinders_on_short_arcs():
    cone = {"set": "cone-arcs", "groups": {"shape": "cone"}}
    assert is_first(record("cone", "cone")) and is_first(several("cone", "cone", "cylinder"))
    assert not is_first(several("cone", "cylinder", "cone")) and not is_first(record("cone", "no_fit"))
    assert is_cylinder_alone(record("cone", "cylinder"))
    assert not is_cylinder_alone(several("cone", "cylinder", "cone"))
    records = [record("cone", "cylinder", **cone)] + [record("cone", "cone", **cone)] * 19
    assert met("short arcs of cones", "`cylinder`", records) and met("short arcs of cones", "`cone`", records)
    assert not met("short arcs of cones", "`cylinder`", records[:19])


def test_bars_are_refused_or_their_deviation_named():
    assert is_cautious(record("foreign", "no_fit")) and is_cautious(record("foreign", "ambiguous"))
    assert is_cautious(record("foreign", "cylinder", note="cylinder: deviates smoothly by 0.3 mm"))
    assert not is_cautious(record("foreign", "cylinder")) and not is_cautious(record("foreign", "failed"))


def test_foreign_shapes_are_asked_by_how_far_they_are_off():
    def foreign(deviation: str, answer: str, note: str = "") -> Record:
        return record("foreign", answer, set="foreign", groups={"deviation": deviation}, note=note)

    near, far = "foreign shapes off every kind by 1 to 3", "foreign shapes off every kind by 3"
    named = foreign("1 to 3", "torus", "torus: they deviate smoothly by 0.3 mm")
    records = [named, foreign("under 1", "plane"), foreign("over 3", "no_fit")]
    (cautious,) = [bar for bar in SHAPE_BARS if bar.case.startswith(near)]
    (refused,) = [bar for bar in SHAPE_BARS if bar.case.startswith(far)]
    assert met(cautious.case, cautious.bar, records) and met(refused.case, refused.bar, records)
    assert not met(cautious.case, cautious.bar, [named, foreign("1 to 3", "torus")])
    assert not met(refused.case, refused.bar, [*records, foreign("over 3", "torus", named.note)])
