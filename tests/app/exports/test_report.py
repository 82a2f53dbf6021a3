"""Reports are whole, self-contained, the same again, small, and honest about what was not found."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from typer.testing import CliRunner

import primfit
from primfit.app.cli.commands import app
from primfit.app.exports.fitted import fitted_points
from primfit.app.exports.options import ExportOptions
from primfit.app.exports.report import html_report, scene_svg
from primfit.fitting.geometry.vectors import Array
from tests.app.exports.test_step import PIECES, recognized

VOID = ("meta",)
CSV = Path(__file__).parents[3] / "app" / "examples" / "cylinder.csv"


class _Page(HTMLParser):
    """The tags of a page, all of which are closed in their order, and its text by tag."""

    def __init__(self, content: bytes) -> None:
        super().__init__()
        self.open: list[str] = []
        self.counts: dict[str, int] = {}
        self.texts: dict[str, list[str]] = {}
        self.feed(content.decode())
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.counts[tag] = self.counts.get(tag, 0) + 1
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open:
            self.texts.setdefault(self.open[-1], []).append(data)


def _points(name: str, n: int = 4000) -> Array:
    primitive, u, v = PIECES[name]
    rng = np.random.default_rng(5)
    feet = primitive.surface(rng.uniform(*u, n), rng.uniform(*v, n))
    return feet + rng.normal(0.0, 0.02, (n, 3))


@pytest.mark.parametrize("name", PIECES)
def test_a_page_is_whole_and_needs_nothing_else(name: str) -> None:
    points, kind = _points(name), PIECES[name][0].kind
    recognition = primfit.fit(points, kinds=[kind])
    content = primfit.export(recognition, "report", points)
    assert content == primfit.export(recognition, "report", points)
    page = _Page(content)
    assert page.counts["svg"] == 5 and "script" not in page.counts and "img" not in page.counts
    assert not re.search(rb"https?:|url\(|src=|href=|@import", content)
    assert not re.search(rb"\b(nan|inf)\b", content)
    assert page.texts["h1"] == [kind.capitalize()] and page.texts["small"] == ["fitted"]
    assert len(content) < 500_000


def test_many_points_make_no_larger_page() -> None:
    points = _points("full torus", 200_000)
    content = primfit.export(primfit.fit(points, kinds=["torus"]), "report", points)
    assert len(content) < 1_000_000
    assert b"3,000 of 200,000 points" in content


def test_the_form_error_is_that_of_the_artifact() -> None:
    points = _points("pipe")
    files = primfit.export(primfit.fit(points), ("form", "report"), points, unit="inch")
    form = json.loads(files["form"])
    assert form["form"] == "cylindricity" and form["n_inliers"] == form["residuals"]["inliers"]["n_points"]
    width = form["minimum_zone"]["form_error"]
    assert width < form["least_squares"]["form_error"] < 0.2
    assert f"<dd>{width:.4g} inch</dd>" in files["report"].decode()
    assert sum(form["residuals"]["all"]["histogram"]["counts"]) == len(points)


def test_no_fit_shows_the_points_and_says_why() -> None:
    points = np.random.default_rng(0).normal(0.0, 1.0, (500, 3))
    recognition = primfit.fit(points)
    assert recognition.status == "no_fit" and recognition.primitive
    page = _Page(primfit.export(recognition, "report", points))
    assert page.texts["small"] == ["no fit"] and recognition.message in page.texts["p"]
    assert page.counts["svg"] == 3 and page.counts["dl"] == 1
    flat = points * [1.0, 1.0, 0.0]
    page = _Page(primfit.export(primfit.fit(flat, kinds=["torus"]), "report", flat))
    assert "The points" in page.texts["h2"] and "Kinds tried" in page.texts["h2"]


def test_ambiguous_answers_show_the_first_and_name_the_others() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(40)])
    points = np.vstack([ring, 2.0 * ring + [0.0, 0.0, 3.0]])
    recognition = primfit.fit(points)
    assert recognition.status == "ambiguous" and recognition.primitive
    page = _Page(primfit.export(recognition, "report", points))
    assert page.texts["small"] == ["ambiguous"] and page.texts["h1"] == [
        recognition.primitive.kind.capitalize()
    ]
    assert {f"Alternative: {other.primitive.kind}" for other in recognition.alternatives} <= set(
        page.texts["h2"]
    )


def test_points_without_an_extent_or_a_scatter_have_a_page() -> None:
    line = np.vstack([np.outer(np.arange(50.0), [1.0, 0.0, 0.0]), [[0.0, 1.0, 0.0]]])
    corners = np.eye(3)
    for points in (line, corners, corners * 1e-90, corners * 1e90):
        _Page(primfit.export(primfit.fit(points, kinds=["plane"]), "report", points))


def test_text_of_the_input_is_escaped(tmp_path: Path) -> None:
    file = tmp_path / "hostile.csv"
    rows = CSV.read_text().splitlines()[2:]
    file.write_text("\n".join(["x[<script>alert(1)</script>&],y,z", *rows]))
    result = CliRunner().invoke(app, ["fit", str(file), "--report", str(tmp_path / "report.html")])
    assert result.exit_code == 0, result.stderr
    content = (tmp_path / "report.html").read_bytes()
    page = _Page(content)
    assert "script" not in page.counts and b"&lt;script&gt;" in content
    assert any("x[<script>" in text for text in page.texts["code"])


def test_the_receipt_holds_the_options_where_they_are_known() -> None:
    recognition = recognized("pipe")
    points = _points("pipe")
    assert b"not known" in primfit.export(recognition, "report", points)
    weights, guess = np.ones(len(points)), recognition.primitive
    options = {"kinds": ["cylinder"], "seed": 7, "weights": weights, "initial_guess": guess}
    known = primfit.export(recognition, "report", points, options=options)
    assert b"not known" not in known and b"<code>7</code>" in known and b"SHA-256 of the weights" in known
    with pytest.raises(primfit.InvalidOptionError, match="seed"):
        primfit.export(recognition, "report", points, options={"seed": -1})


def test_points_of_another_cloud_are_measured_but_make_no_report() -> None:
    recognition, away = recognized("pipe"), _points("pipe") + 1e3
    assert not primfit.residuals(recognition, away).inlier.any()
    assert json.loads(primfit.export(recognition, "form", away))["residuals"]["inliers"] is None
    with pytest.raises(primfit.NothingToExportError, match="none of the 4000 points"):
        primfit.export(recognition, "report", away)


def test_places_keep_their_digits_far_from_the_origin() -> None:
    points = _points("half pipe") + np.array([450_000.0, 5_400_000.0, 0.0])
    recognition = primfit.fit(points, kinds=["cylinder"])
    page = _Page(primfit.export(recognition, "report", points))
    assert recognition.extents
    written = {text.rstrip(",") for text in page.texts["span"]}
    assert {f"{number:.4f}" for number in recognition.extents.values()["start"]} <= written


@pytest.mark.parametrize("name", ["plane", "pipe"])
def test_the_scene_is_a_picture_by_itself(name: str) -> None:
    points = _points(name)
    recognition = primfit.fit(points, kinds=[PIECES[name][0].kind])
    picture = ElementTree.fromstring(scene_svg(fitted_points(recognition, points)))
    namespace = "{http://www.w3.org/2000/svg}"
    assert picture.tag == f"{namespace}svg"
    assert "svg.primfit .edge" in picture.findtext(f"{namespace}style", "")
    assert picture.findall(f".//{namespace}path[@class='edge']")


def test_title_date_operator_and_unit_are_those_given() -> None:
    points = _points("pipe")
    recognition = primfit.fit(points)
    plain = _Page(primfit.export(recognition, "report", points, unit="mm"))
    assert plain.texts["dt"][:2] == ["points", "unit"] and plain.texts["dd"][:2] == ["4,000", "mm"]
    given = {"title": "Bore <3>", "date": "29.11.2026", "operator": "A. & B."}
    page = _Page(primfit.export(recognition, "report", points, **given))
    assert page.texts["h1"] == ["Bore <3>"] and page.texts["title"][0] == "Bore <3>"
    assert page.texts["dt"][:2] == ["date", "operator"] and page.texts["dd"][:2] == ["29.11.2026", "A. & B."]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"title": "x" * 201}, "title is 201 characters long; at most 200"),
        ({"operator": "a\nb"}, "operator holds line breaks"),
        ({"date": 20261129}, "date is of type int"),
    ],
)
def test_what_a_report_cannot_show_is_refused(given: dict[str, object], told: str) -> None:
    with pytest.raises(primfit.InvalidOptionError, match=told):
        primfit.export(recognized("pipe"), "report", _points("pipe"), **given)  # type: ignore[call-overload]


def test_without_a_unit_none_is_printed() -> None:
    points = _points("pipe")
    page = _Page(html_report(fitted_points(primfit.fit(points), points), ExportOptions()))
    said = [text for texts in page.texts.values() for text in texts]
    assert "not given" in page.texts["dd"]
    assert not [text for text in said if re.search(r"\d (mm|µm|m)\b|\[(mm|µm|m)\]|None", text)]


def test_the_first_page_leads_with_what_people_look_for() -> None:
    points = _points("pipe")
    recognition = primfit.fit(points, unit="mm")
    assert recognition.primitive and recognition.uncertainty
    content = primfit.export(recognition, "report", points).decode()
    lead = content[content.index('class="figures"') : content.index("<h2>")]
    names = re.findall(r"<dt>([^<]*)</dt>", lead)
    assert names == ["kind", "diameter", "radius", "length", "cylindricity", "rms of inliers", "inliers"]
    interval = recognition.uncertainty.intervals["radius"]
    assert interval.high is not None and interval.low is not None
    known = re.findall(r'<dd>([\d.]+) mm</dd><dd class="known">±\u00a0([\d.]+)</dd>', lead)
    (diameter, twice), (radius, half) = ((float(a), float(b)) for a, b in known)
    assert radius == pytest.approx(recognition.primitive.radius, abs=0.1 * half)  # type: ignore[attr-defined]
    assert half == pytest.approx((interval.high - interval.low) / 2.0, rel=0.05)
    assert (diameter, twice) == (
        pytest.approx(2.0 * radius, abs=0.1 * twice),
        pytest.approx(2.0 * half, rel=0.05),
    )
    assert 'known">of 4,000 points<' in lead


def test_rounding_is_no_residual() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(40)])
    points = np.vstack([ring, 2.0 * ring + [0.0, 0.0, 3.0]])
    content = primfit.export(primfit.fit(points), "report", points)
    page = _Page(content)
    assert page.counts["svg"] == 3 and b"to the rounding of their coordinates" in content
    assert not [text for text in page.texts["td"] if re.search(r"e-1\d", text)]
