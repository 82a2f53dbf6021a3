"""The examples of docs/python.md print what stands there, and so do those of docstrings."""

import doctest
import re
from importlib.util import find_spec
from typing import Any

import pytest

from primfit.app.engine import estimator
from tests.paths import DOCS, ROOT

TEXT = (DOCS / "python.md").read_text()
SCENE, *BLOCKS = re.findall(r"^```pycon\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE)


def run(block: str, names: dict[str, Any]) -> None:
    """Run a block; what it defines is added to `names`."""
    example = doctest.DocTestParser().get_doctest(block, names, "docs/python.md", "docs/python.md", 0)
    runner = doctest.DebugRunner()
    runner.run(example, clear_globs=False)
    names.update(example.globs)


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What the first block defines: a cloud and its answer."""
    monkeypatch.chdir(ROOT)
    names: dict[str, Any] = {}
    run(SCENE, names)
    return names


@pytest.mark.parametrize("block", BLOCKS, ids=[block.partition("\n")[0][4:40] for block in BLOCKS])
def test_a_block_prints_what_stands_there(block: str, scene: dict[str, Any]) -> None:
    for name in re.findall(r"^>>> (?:import|from) (\w+)", block, re.MULTILINE):
        if find_spec(name) is None:
            pytest.skip(f"needs {name}")
    run(block, scene)


def test_the_example_of_the_estimator_runs() -> None:
    failures, tried = doctest.testmod(estimator)
    assert tried > 0
    assert failures == 0
