"""An answer that went through JSON is the same answer."""

import numpy as np
import orjson
import pytest

import primfit
from primfit.app.engine.answer import answered, to_json
from primfit.app.readers.cloud import Cloud
from primfit.fitting.answer.restored import restored
from primfit.fitting.answer.result import Recognition
from tests.fitting.clouds import EXAMPLES, noisy

RINGS = [
    [scale * x, scale * y, z]
    for scale, z in ((1.0, 0.0), (2.0, 1.0))
    for x, y in zip(np.cos(np.linspace(0, 6, 60)), np.sin(np.linspace(0, 6, 60)), strict=True)
]
NOMINAL = {
    "kind": "cylinder",
    "radius": {"value": 0.8, "tolerance": 0.1},
    "axis": {"value": [0.2, 0.9, 0.3], "tolerance": 0.1},
}
ASKED = {
    **{kind: (noisy(EXAMPLES[kind], 300, 0.005), {}) for kind in EXAMPLES},
    "ambiguous": (np.array(RINGS), {"kinds": ["sphere", "cone"]}),
    "no_fit": (np.random.default_rng(0).uniform(size=(400, 3)), {}),
    "no primitive": (noisy(EXAMPLES["plane"], 300, 0.0), {"kinds": ["torus"]}),
    "nominal": (noisy(EXAMPLES["cylinder"], 300, 0.005), {"nominal": NOMINAL, "form_tolerance": 0.1}),
    "limited": (noisy(EXAMPLES["sphere"], 300, 0.005), {"constraints": {"radius": {"min": 1.0, "max": 1.1}}}),
    "parts left out": (noisy(EXAMPLES["sphere"], 300, 0.005), {"include": ["uncertainty"]}),
}


def asked(name: str) -> tuple[Recognition, bytes]:
    points, options = ASKED[name]
    found, answer = answered(Cloud(points, ("x", "y", "z"), None, "csv", unit="m"), options)
    return found, to_json(answer)


@pytest.mark.parametrize("name", ASKED)
def test_it_says_the_same(name: str) -> None:
    found, answer = asked(name)
    again = restored(orjson.loads(answer))
    assert to_json(again.to_dict()) == to_json(found.to_dict())
    assert str(again) == str(found)
    assert (again.n_points, again.unit, again.include) == (found.n_points, found.unit, found.include)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_it_is_exported_as_the_same_bytes(kind: str) -> None:
    found, answer = asked(kind)
    again = restored(orjson.loads(answer))
    for artifact in ("step", "glb", "csv", "obj"):
        assert primfit.export(again, artifact) == primfit.export(found.with_points(found.points), artifact)


def test_all_cases_are_what_they_are_called() -> None:
    statuses = {name: asked(name)[0].status for name in ("ambiguous", "no_fit", "no primitive", "cone")}
    assert statuses == {
        "ambiguous": "ambiguous",
        "no_fit": "no_fit",
        "no primitive": "no_fit",
        "cone": "fitted",
    }
    assert asked("no primitive")[0].primitive is None


def test_what_is_no_answer_is_refused() -> None:
    with pytest.raises(KeyError):
        restored({"status": "fitted"})
