"""The report holds what was found against what was asked for."""

import re
from dataclasses import dataclass

import primfit
from primfit.app.exports.fitted import fitted_points
from primfit.app.exports.options import ExportOptions
from primfit.app.exports.report import html_report
from primfit.app.exports.report.conformance import checks_table
from tests.app.exports.test_report import _points as points_of


@dataclass(frozen=True)
class Check:
    name: str
    nominal: float | tuple[float, ...]
    deviation: float
    low: float | None = None
    high: float | None = None
    lower: float | None = None
    upper: float | None = None
    verdict: str | None = None


def _cells(check: Check, unit: str | None = "mm") -> list[str]:
    row = checks_table([check], unit).rpartition("<tbody>")[2]
    return [re.sub("<[^>]*>", "", cell) for cell in re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row)]


def test_a_row_has_one_unit_and_the_digits_of_its_interval() -> None:
    radius = Check("radius", 8.0, 0.00031, 0.00023, 0.00039, -0.01, 0.02, "within")
    assert _cells(radius) == ["radius", "8 mm", "0.310 µm", "0.230 to 0.390 µm", "-10 to 20 µm", "within"]
    form = Check("form", 0.0, 0.0128, lower=0.0, upper=0.01, verdict="beyond")
    assert _cells(form) == ["form", "", "12.80 µm", "", "0 to 10 µm", "beyond"]
    center = Check("center", (1.0, 2.0, 3.5), 0.25, 0.2, 0.3, 0.0, 0.28, "undecided")
    assert _cells(center, None) == [
        "center",
        "1, 2, 3.5",
        "0.250",
        "0.200 to 0.300",
        "0 to 0.28",
        "undecided",
    ]


def test_angles_are_in_degrees_and_nothing_is_made_up() -> None:
    tilt = Check("axis", (0.0, 0.0, 1.0), 0.01, 0.008, 0.012)
    assert _cells(tilt) == ["axis", "0, 0, 1", "0.57\u00b0", "0.46 to 0.69\u00b0", "", ""]
    exact = Check("half_angle", 0.5, 0.0)
    assert _cells(exact, None) == ["half-angle", "28.6478898\u00b0", "0\u00b0", "", "", ""]


@dataclass(frozen=True)
class Conformance:
    verdict: str | None
    kind: str | None
    checks: tuple[Check, ...] = ()


def test_the_verdict_leads() -> None:
    points = points_of("pipe")
    fitted = fitted_points(primfit.fit(points), points)
    assert "Tolerances" not in html_report(fitted, ExportOptions()).decode()
    asked = Conformance(
        "beyond", "cylinder", (Check("form", 0.0, 0.2, lower=0.0, upper=0.1, verdict="beyond"),)
    )
    object.__setattr__(fitted.recognition, "conformance", asked)
    page = html_report(fitted, ExportOptions()).decode()
    assert "<dt>verdict</dt><dd>beyond tolerance</dd>" in page
    assert "<h2>Tolerances</h2><p>Beyond tolerance.</p>" in page and "0 to 0.1 mm" in page
    object.__setattr__(fitted.recognition, "conformance", Conformance("beyond", None))
    assert "Another shape than asked for." in html_report(fitted, ExportOptions()).decode()
