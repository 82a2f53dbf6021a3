"""requirements/: the versions that pyproject.toml allows, with hashes and nothing beyond."""

import re
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.installing import ROOT
from tests.test_packaging import PROJECT

LOCKS = ROOT / "requirements"
EXTRAS = {"image": ("postgres",), "full": ("bench", "cad", "e57", "mcp", "otel", "postgres"), "dev": ("dev",)}


def _pins(name: str) -> dict[str, list[Requirement]]:
    """The pinned requirements of a lock by their name; one name may be pinned for several Pythons."""
    pins: dict[str, list[Requirement]] = {}
    for line in (LOCKS / f"{name}.txt").read_text().splitlines():
        if line[:1].isalnum():
            requirement = Requirement(line.removesuffix("\\").strip())
            pins.setdefault(canonicalize_name(requirement.name), []).append(requirement)
    return pins


def _asked(name: str) -> list[Requirement]:
    """What pyproject.toml asks for in this lock."""
    if name == "build":
        texts = PROJECT["build-system"]["requires"]
    else:
        project = PROJECT["project"]
        extras = project["optional-dependencies"]
        texts = project["dependencies"] + [text for extra in EXTRAS[name] for text in extras[extra]]
    return [Requirement(text) for text in texts]


@pytest.mark.parametrize("lock", ["build", *EXTRAS])
def test_each_version_is_one_that_the_project_allows(lock: str) -> None:
    pins = _pins(lock)
    for asked in _asked(lock):
        for pin in pins[canonicalize_name(asked.name)]:
            (version,) = [specifier.version for specifier in pin.specifier if specifier.operator == "=="]
            assert asked.specifier.contains(version), f"{pin} beside {asked}: make lock"


@pytest.mark.parametrize("lock", EXTRAS)
def test_what_it_holds_for_the_project_is_what_the_project_asks_for(lock: str) -> None:
    entries = re.split(r"\n(?=\w)", (LOCKS / f"{lock}.txt").read_text())
    held = {entry.partition("==")[0] for entry in entries if "primfit (pyproject.toml)" in entry}
    assert held == {canonicalize_name(asked.name) for asked in _asked(lock)}, "make lock"


@pytest.mark.parametrize("lock", sorted(LOCKS.glob("*.txt")), ids=lambda path: path.stem)
def test_each_has_hashes_and_none_says_where_it_came_from(lock: Path) -> None:
    text = lock.read_text()
    for entry in re.split(r"\n(?=\w)", text)[1:]:
        assert "--hash=sha256:" in entry
    assert "://" not in text and "--index" not in text and "--find-links" not in text


@pytest.mark.parametrize("lock", ["build", "image", "full"])
def test_an_image_holds_the_versions_that_were_tested(lock: str) -> None:
    tested = _pins("dev")
    for name, pins in _pins(lock).items():
        for pin in pins if name in tested else []:
            assert pin.specifier in [other.specifier for other in tested[name]]
    assert "torch" not in _pins(lock)
