"""The report holds what was found against what was asked for."""

import re
from dataclasses import replace
from typing import Any

import numpy as np

import primfit
from primfit.app.exports.report.conformance import checks_table
from primfit.fitting.answer.conformance import Check
from tests.app.exports.test_report import _points as points_of


def _check(name: str, nominal: Any, deviation: float, *ends: float, **allowed: Any) -> Check:
    low, high = ends or (None, None)
    beside = {"lower": None, "upper": None, "verdict": None} | allowed
    return Check(name, nominal, 0.0, deviation, low, high, **beside)


def _cells(check: Check, unit: str | None = "mm") -> list[str]:
    row = checks_table([check], unit).rpartition("<tbody>")[2]
    return [re.sub("<[^>]*>", "", cell) for cell in re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row)]


def test_a_row_has_one_unit_and_the_digits_of_its_interval() -> None:
    radius = _check("radius", 8.0, 0.00031, 0.00023, 0.00039, lower=-0.01, upper=0.02, verdict="within")
    assert _cells(radius) == ["radius", "within", "0.310 µm", "-10 to 20 µm", "0.230 to 0.390 µm", "8 mm"]
    form = _check("form", 0.0, 0.0128, lower=0.0, upper=0.01, verdict="beyond")
    assert _cells(form) == ["form", "beyond", "12.80 µm", "0 to 10 µm", "", ""]
    center = _check("center", (1.0, 2.0, 3.5), 0.25, 0.2, 0.3, lower=0.0, upper=0.28, verdict="undecided")
    assert _cells(center, None) == [
        "center",
        "undecided",
        "0.250",
        "0 to 0.28",
        "0.200 to 0.300",
        "1, 2, 3.5",
    ]


def test_angles_are_in_degrees_and_nothing_is_made_up() -> None:
    tilt = _check("axis", (0.0, 0.0, 1.0), 0.01, 0.008, 0.012)
    assert _cells(tilt) == ["axis", "", "0.57\u00b0", "", "0.46 to 0.69\u00b0", "0, 0, 1"]
    exact = _check("half_angle", 0.5, 0.0)
    assert _cells(exact, None) == ["half-angle", "", "0\u00b0", "", "", "28.6478898\u00b0"]


def test_the_verdict_leads() -> None:
    points = points_of("pipe")
    assert b"Tolerances" not in _report(points)
    page = _report(points, form_tolerance=1e-9)
    assert b"<dt>verdict</dt><dd>beyond tolerance</dd>" in page
    assert b"<h2>Tolerances</h2><p>Beyond tolerance.</p>" in page and b"0 to " in page
    assert b"Another shape than asked for." in _report(points, nominal={"kind": "sphere"})


def _report(points: Any, **options: Any) -> bytes:
    return primfit.export(primfit.fit(points, unit="mm", **options), "report")


def test_an_interval_with_an_open_end_has_the_other_one() -> None:
    radius = _check("radius", 8.0, 0.5, lower=-1.0, upper=1.0, verdict="undecided")
    assert _cells(replace(radius, low=-0.25))[4] == "at least -0.25 mm"
    assert _cells(replace(radius, high=0.75))[4] == "at most 0.75 mm"


def test_where_nothing_fits_the_verdict_claims_no_other_shape() -> None:
    page = _report(np.random.default_rng(0).normal(size=(300, 3)), form_tolerance=1.0)
    assert b"Beyond tolerance: no kind explains the points." in page


def test_warnings_about_the_points_are_in_the_report() -> None:
    for points in (points_of("pipe"), np.random.default_rng(0).normal(size=(300, 3))):
        page = _report(np.vstack([points, [[np.nan, 0.0, 0.0]]]))
        assert b"<li>Missing points were dropped: 1 with coordinates that are not finite.</li>" in page
