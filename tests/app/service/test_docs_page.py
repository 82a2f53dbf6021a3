"""The page at /docs in a real browser: it shows every operation, fits clouds, and asks the service alone."""

import re
from collections.abc import Iterator
from typing import Any

import pytest

from tests.app.browser import WITHOUT_GRAPHICS, Browser, browser, needs_browser, wait_for
from tests.paths import EXAMPLES

pytestmark = [pytest.mark.browser, needs_browser]


@pytest.fixture(scope="module")
def page(service: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """The documentation, drawn."""
    with browser(tmp_path_factory.mktemp("profile"), WITHOUT_GRAPHICS) as started:
        started.open(f"http://127.0.0.1:{service.port}/docs")
        started.wait_for("document.getElementById('schemas') !== null")
        yield started


def test_it_shows_every_operation(page: Browser, service: Any) -> None:
    document = service.client.get("/openapi.json").json()
    headings = page.run("return [...document.querySelectorAll('main h2')].map(h => [h.id, h.textContent])")
    expected = {
        operation["operationId"]: f"{method.upper()} {path} {operation['summary']}"
        for path, methods in document["paths"].items()
        for method, operation in methods.items()
    }
    assert dict(headings) == expected | {"schemas": "Schemas"}
    links = page.run("return [...document.querySelectorAll('nav a')].map(a => a.hash.slice(1))")
    assert sorted(links) == sorted([*expected, "schemas"])


def _found(page: Browser) -> str:
    answers = "return [...document.querySelectorAll('.found')].map(found => found.textContent)"
    wait_for(lambda: page.run(answers) != [])
    return str(page.run(answers)[0])


def _clear(page: Browser) -> None:
    page.run("document.querySelectorAll('.found').forEach(found => found.remove())")


def test_it_fits_the_example(page: Browser) -> None:
    page.click("#fit + p + .trial .send")
    assert re.search(r"cylinder, fitted.*radius.*12\.(49|50)", _found(page))


def test_it_fits_a_file_with_options(page: Browser) -> None:
    page.type("#fit + p + .trial input[type=file]", str(EXAMPLES / "cylinder.csv"))
    page.type("#fit + p + .trial input[type=text]", '{"kinds": ["sphere"]}')
    _clear(page)
    page.click("#fit + p + .trial .send")
    assert "sphere, no_fit" in _found(page)


def test_it_says_the_unit_the_verdict_and_what_to_know(page: Browser) -> None:
    page.run(
        """document.querySelector('#fit + p + .trial input[type=text]').value =
        '{"kinds": ["cylinder"], "unit": "mm", "form_tolerance": 1e-9, "columns": [1, 2, 3]}'"""
    )
    _clear(page)
    page.click("#fit + p + .trial .send")
    found = _found(page)
    assert re.search(r"radius\s*12\.5\d* mm", found) and "Tolerances: beyond." in found
    assert re.search(r"axis\s*[-\d., ]+\d\s*point", found)


def test_it_draws_the_points_that_were_sent(page: Browser) -> None:
    _clear(page)
    page.run("document.querySelector('#fit + p + .trial input[type=file]').value = ''")
    page.click("#fit + p + .trial .send")
    _found(page)
    sides = page.run(
        "return [...document.querySelectorAll('#fit + p + .trial circle')].map(c => c.className.baseVal)"
    )
    assert len(sides) == 40 and set(sides) == {"inside", "outside"}
    assert page.run("return document.querySelectorAll('#fit + p + .trial polyline').length") == 15


def test_it_exports_and_hands_out_the_files(page: Browser) -> None:
    _clear(page)
    page.click("#fit_export + p + .trial .send")
    _found(page)
    wait_for(lambda: page.run("return document.querySelector('iframe') !== null"))
    links = page.run("return [...document.querySelectorAll('.files a')].map(a => a.download)")
    assert links == ["primfit.zip", "answer.json", "primitive.glb", "primitive.csv", "report.html"]
    assert page.run("return document.querySelector('iframe').srcdoc").startswith("<!doctype html>")


def test_options_have_fields(page: Browser, service: Any) -> None:
    """Those of the query and the headers; an option that is chosen arrives."""
    document = service.client.get("/openapi.json").json()
    for path in ("/fit", "/fit/export", "/fit/batch"):
        operation = document["paths"][path]["post"]
        names = [parameter.get("name", "X-Request-Id") for parameter in operation["parameters"]]
        script = f"return document.querySelector('#{operation['operationId']} + p + .trial').textContent"
        assert all(name in page.run(script) for name in names)
    _clear(page)
    chosen = "#fit + p + .trial input[value=sphere]"
    page.run(f"document.querySelector('{chosen}').closest('details').open = true")
    page.click(chosen)
    page.click("#fit + p + .trial .send")
    assert "sphere, no_fit" in _found(page)
    page.click(chosen)


def test_it_fits_on_a_phone(page: Browser) -> None:
    page.resize(360)
    page.run("document.querySelectorAll('details').forEach(details => { details.open = true; })")
    assert page.run("return document.documentElement.scrollWidth") == 360
    page.resize(1100)


def test_it_runs_no_script_but_its_own(page: Browser, service: Any) -> None:
    policy = service.client.get("/docs").headers["content-security-policy"]
    assert "default-src 'none'" in policy and "unsafe-eval" not in policy
    page.run(
        "const script = document.createElement('script'); script.textContent = 'window.foreign = true';"
        "document.body.append(script)"
    )
    assert page.run("return window.foreign === undefined")


def test_it_asks_nobody_but_the_service(page: Browser) -> None:
    page.click("#livez + p + .trial .send")
    wait_for(lambda: "alive" in page.run("return document.querySelector('#livez + p + .trial').textContent"))
    assert page.hosts() == {"127.0.0.1"}
