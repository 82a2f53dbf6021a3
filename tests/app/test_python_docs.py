"""The examples of docs/python.md print what stands there, and so do those of public docstrings."""

import doctest
import re
from importlib.util import find_spec
from typing import Any

import pytest

import primfit
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


@pytest.mark.parametrize("name", sorted(set(primfit.__all__) - {"KINDS", "__version__"}))
def test_what_is_public_has_an_example_that_runs(name: str) -> None:
    if name.startswith("show"):
        pytest.importorskip("k3d", reason="needs the extra notebook: pip install 'primfit[notebook]'")
    public = getattr(primfit, name)
    examples = doctest.DocTestParser().get_examples(public.__doc__)
    assert examples
    example = doctest.DocTest(examples, {}, name, None, None, public.__doc__)
    assert doctest.DocTestRunner().run(example).failed == 0
