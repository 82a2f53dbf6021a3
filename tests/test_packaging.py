"""What is shipped: one package, the weights, the examples, one version, a container without torch."""

import shutil
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import entry_points, version
from pathlib import Path

import pytest

from tests.paths import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
HOUSES = ("app", "benchmark", "fitting", "models", "synthetic")


def test_every_module_lies_in_a_package() -> None:
    for house in HOUSES:
        for module in (ROOT / house).rglob("*.py"):
            assert (module.parent / "__init__.py").exists(), module


def test_installed_version_is_the_one_of_the_project() -> None:
    assert version("primfit") == PROJECT["project"]["version"]
    assert f"\n## {PROJECT['project']['version']}" in (ROOT / "CHANGELOG.md").read_text()


def test_command_is_installed() -> None:
    (command,) = entry_points(group="console_scripts", name="primfit")
    assert callable(command.load())


def test_serving_needs_no_torch() -> None:
    assert not any(name.startswith("torch") for name in PROJECT["project"]["dependencies"])
    assert any(name.startswith("torch") for name in PROJECT["project"]["optional-dependencies"]["train"])


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    """The wheel, built from a copy so that the working tree stays as it is, and compiled quickly."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    source.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE", "src", *HOUSES):
        _copy(ROOT / name, source / name)
    project = source / "pyproject.toml"
    project.write_text(project.read_text().replace('"-O3"', '"-O0"'))
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir", str(folder)]
    subprocess.run([sys.executable, "-m", "pip", "wheel", *options, str(source)], check=True)
    (built,) = folder.glob("primfit-*.whl")
    return zipfile.ZipFile(built)


@pytest.mark.slow
def test_wheel_holds_code_weights_examples_and_licence(wheel: zipfile.ZipFile) -> None:
    names = set(wheel.namelist())
    for file in [*(ROOT / "models" / "weights").glob("*.*"), *(ROOT / "app" / "examples").iterdir()]:
        assert f"primfit/{file.relative_to(ROOT)}" in names
    for house in HOUSES:
        for module in (ROOT / house).rglob("*.py"):
            assert f"primfit/{module.relative_to(ROOT)}" in names
    assert {"primfit/__init__.py", "primfit/__main__.py", "primfit/py.typed"} <= names
    assert any(name.endswith("licenses/LICENSE") for name in names)


@pytest.mark.slow
def test_wheel_installs_one_name(wheel: zipfile.ZipFile) -> None:
    assert {name.split("/")[0].split("-")[0] for name in wheel.namelist()} == {"primfit"}


def test_image_runs_without_rights_and_has_a_health_check() -> None:
    lines = (ROOT / "Dockerfile").read_text().splitlines()
    assert any(line.startswith("USER ") and "root" not in line and " 0" not in line for line in lines)
    assert any(line.startswith("HEALTHCHECK") for line in lines)
    assert any(line.startswith("ARG BASE_IMAGE") for line in lines)
    assert not any("torch" in line for line in lines if not line.startswith("#"))


def _copy(source: Path, target: Path) -> None:
    if source.is_file():
        shutil.copyfile(source, target)
    else:
        shutil.copytree(
            source, target, symlinks=True, ignore=shutil.ignore_patterns("__pycache__", "*.so", "*.egg-info")
        )
