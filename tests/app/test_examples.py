"""The examples: the answer that the OpenAPI document shows is what the service gives; the scan is ours."""

import json
import math
import re
from dataclasses import replace

import numpy as np

from primfit.app.cli.files import answer_file
from primfit.app.engine.segments import fit_segments
from primfit.app.readers import Pick, read_file
from primfit.synthetic.draw import clouds
from primfit.synthetic.recipes import RECIPES
from tests.paths import EXAMPLES


def _same(shown: object, given: object) -> bool:
    """Equal but for what another machine changes: last digits, and the versions of NumPy and SciPy."""
    match shown, given:
        case dict(), dict():
            names = (shown.keys() | given.keys()) - {"numpy", "scipy"}
            return all(_same(shown.get(name), given.get(name)) for name in names)
        case list(), list():
            return len(shown) == len(given) and all(map(_same, shown, given))
        case float(), float():
            return math.isclose(shown, given, rel_tol=1e-6)
        case str(), str() if " " in shown:
            return _words(shown) == _words(given)
        case _:
            return shown == given


def _words(sentence: str) -> str:
    return re.sub(r"\d[\d.e+-]*", "#", sentence)


def test_the_answer_shown_is_the_one_given_now() -> None:
    given = answer_file(str(EXAMPLES / "request.json"), {})[1]
    shown = json.loads((EXAMPLES / "answer.json").read_bytes())
    assert shown["primitive"]["kind"] == "cylinder" and math.isclose(
        shown["primitive"]["radius"], 12.5, rel_tol=1e-3
    )
    assert _same(shown, given), "app/examples/answer.json is out of date; refresh it with: make example"


def test_the_segments_are_those_of_the_generator() -> None:
    recipe = replace(RECIPES["scanner"], seed=2354)
    drawn = list(clouds(recipe, 3))
    cloud = read_file(EXAMPLES / "segments.csv", pick=Pick("label"))
    np.testing.assert_allclose(cloud.points, np.vstack([one.points for one in drawn]), rtol=1e-9)
    segments = fit_segments(cloud.points, cloud.labels)
    assert [segment.label for segment in segments] == [1, 2, 3]
    for segment, one in zip(segments, drawn, strict=True):
        assert segment.recognition is not None and segment.recognition.status == "fitted"
        assert segment.recognition.primitive.kind == one.kind
