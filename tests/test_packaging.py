"""What is shipped: one package, the weights, the examples, one version, a container without torch."""

import re
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import entry_points, version

import pytest
import yaml

from tests.installing import HOUSES, ROOT, build_wheel, copy_sources

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
SOURCES = sorted([*(ROOT / "fitting").glob("*/*.pyx"), *(ROOT / "models").glob("*.pyx")])


def test_every_module_lies_in_a_package() -> None:
    for house in HOUSES:
        for module in (ROOT / house).rglob("*.py"):
            assert (module.parent / "__init__.py").exists(), module


def test_installed_version_is_the_one_of_the_project() -> None:
    assert version("primfit") == PROJECT["project"]["version"]


def test_changes_and_citation_are_those_of_this_version() -> None:
    latest = re.findall(r"^## \[(\d[^]]*)\]", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)[0]
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())["version"]
    assert [latest, cited] == [PROJECT["project"]["version"]] * 2


@pytest.mark.parametrize(
    ("schema", "files"),
    [
        ("vendor.citation-file-format", "CITATION.cff"),
        ("vendor.github-issue-forms", ".github/ISSUE_TEMPLATE/[!c]*.yml"),
        ("vendor.github-issue-config", ".github/ISSUE_TEMPLATE/config.yml"),
        ("vendor.github-workflows", "deploy/wheels.yml"),
        ("vendor.compose-spec", "compose.yaml"),
        ("vendor.compose-spec", "deploy/compose.*.yaml"),
    ],
)
def test_files_for_others_follow_their_schema(schema: str, files: str) -> None:
    found = [str(file) for file in ROOT.glob(files)]
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", schema, *found]
    done = subprocess.run(command, capture_output=True, text=True)
    assert found and done.returncode == 0, done.stdout


def test_command_is_installed() -> None:
    (command,) = entry_points(group="console_scripts", name="primfit")
    assert callable(command.load())


def test_serving_needs_no_torch() -> None:
    assert not any(name.startswith("torch") for name in PROJECT["project"]["dependencies"])
    assert any(name.startswith("torch") for name in PROJECT["project"]["optional-dependencies"]["train"])


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    """The wheel, built from a copy of the sources."""
    folder = tmp_path_factory.mktemp("wheel")
    return zipfile.ZipFile(build_wheel(copy_sources(folder / "source"), folder))


@pytest.mark.slow
def test_wheel_holds_code_weights_examples_and_license(wheel: zipfile.ZipFile) -> None:
    names = set(wheel.namelist())
    for file in [*(ROOT / "models" / "weights").glob("*.*"), *(ROOT / "app" / "examples").iterdir()]:
        assert f"primfit/{file.relative_to(ROOT)}" in names
    for house in HOUSES:
        for module in (ROOT / house).rglob("*.py"):
            assert f"primfit/{module.relative_to(ROOT)}" in names
    assert {"primfit/__init__.py", "primfit/__main__.py", "primfit/py.typed"} <= names
    assert any(name.endswith("licenses/LICENSE") for name in names)
    assert not any(name.startswith("primfit/paper/") for name in names)


@pytest.mark.slow
def test_wheel_holds_what_is_compiled_once_for_all_versions_and_no_sources(wheel: zipfile.ZipFile) -> None:
    names = wheel.namelist()
    compiled = {f"primfit/{source.relative_to(ROOT).with_suffix('.abi3.so')}" for source in SOURCES}
    assert compiled == {name for name in names if name.endswith(".so")}
    assert not [name for name in names if name.endswith((".pyx", ".pxd", ".h", ".c"))]
    assert "cp311-abi3" in str(wheel.filename)


def test_what_is_compiled_is_not_hidden_by_an_older_build() -> None:
    hidden = [
        str(old.relative_to(ROOT)) for source in SOURCES for old in source.parent.glob("_*.cpython-*.so")
    ]
    assert hidden == [], "an older build goes before the new one: remove these files"


@pytest.mark.slow
def test_wheel_installs_one_name(wheel: zipfile.ZipFile) -> None:
    assert {name.split("/")[0].split("-")[0] for name in wheel.namelist()} == {"primfit"}


def test_image_runs_without_rights_and_has_a_health_check() -> None:
    lines = (ROOT / "Dockerfile").read_text().splitlines()
    assert any(line.startswith("USER ") and "root" not in line and " 0" not in line for line in lines)
    assert any(line.startswith("HEALTHCHECK") for line in lines)
    assert any(line.startswith("ARG BASE_IMAGE") for line in lines)
    assert not any("torch" in line for line in lines if not line.startswith("#"))
