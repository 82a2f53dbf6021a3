"""Installed from a wheel, or editable: one name, beside a project's own packages, and types for checkers."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.installing import HOUSES, OFFLINE, Environment, build_wheel, copy_sources

pytestmark = pytest.mark.slow

Check = Callable[[Environment, Path], subprocess.CompletedProcess[str]]

OWN = ("app", "models", "tests")
SCRIPT = """
import json
import app, models, tests
import numpy as np
import primfit

sphere = primfit.Sphere(center=np.zeros(3), radius=2.0)
azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
found = primfit.fit(sphere.surface(azimuth, polar)).primitive
print(json.dumps([app.WHOSE, models.WHOSE, tests.WHOSE, found.kind, round(found.radius, 9)]))
"""
TYPED = """
import numpy as np

import primfit

points = np.random.default_rng(0).normal(size=(100, 3))
recognition: primfit.Recognition = primfit.fit(points, kinds=["sphere"], criterion="robust", seed=1)
found = recognition.primitive
if isinstance(found, primfit.Sphere):
    radius: float = found.radius
    center: float = float(primfit.Sphere(center=found.center, radius=found.radius).center[0])
status: str = recognition.status
"""
WRONG = {
    "radius: float": "radius: str",
    "seed=1": 'seed="one"',
    'kinds=["sphere"]': 'kinds=["cube"]',
    "status: str = recognition.status": "status: str = recognition.state",
}


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copy_sources(tmp_path_factory.mktemp("sources") / "primfit")


@pytest.fixture(scope="module", params=["wheel", "editable"])
def environment(
    request: pytest.FixtureRequest, source: Path, tmp_path_factory: pytest.TempPathFactory
) -> Environment:
    """A fresh environment with primfit in it, installed either way."""
    folder = tmp_path_factory.mktemp(request.param)
    made = Environment(folder / "environment")
    if request.param == "wheel":
        made.install(str(build_wheel(source, folder)))
    else:
        made.install("--editable", str(source))
    return made


def test_nothing_but_primfit_is_installed(environment: Environment, source: Path, tmp_path: Path) -> None:
    (information,) = [name for name in environment.installed() if name.endswith(".dist-info")]
    left = environment.installed() - {information}
    editable = [name for name in left if name.startswith("__editable__")]
    if editable:
        (path,) = (environment.packages / editable[0]).read_text().split()
        left = {name.name for name in Path(path).iterdir() if not name.name.endswith(".egg-info")}
    assert left == {"primfit"}
    script = f"import importlib.util as u; print([n for n in {HOUSES} if u.find_spec(n)])"
    assert environment.run("-c", script, cwd=tmp_path).strip() == "[]"


def test_a_project_with_packages_of_the_same_names_fits_a_cloud(
    environment: Environment, tmp_path: Path
) -> None:
    for name in OWN:
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text(f"WHOSE = 'the {name} of the project'\n")
    (tmp_path / "script.py").write_text(SCRIPT)
    printed = json.loads(environment.run("script.py", cwd=tmp_path))
    assert printed == [*(f"the {name} of the project" for name in OWN), "sphere", 2.0]


def _mypy(environment: Environment, script: Path) -> subprocess.CompletedProcess[str]:
    options = [
        "--strict",
        "--python-executable",
        str(environment.python),
        "--cache-dir",
        str(script.parent / "cache"),
    ]
    command = [sys.executable, "-m", "mypy", *options, script.name]
    return subprocess.run(command, cwd=script.parent, capture_output=True, text=True)


def _pyright(environment: Environment, script: Path) -> subprocess.CompletedProcess[str]:
    (script.parent / "pyrightconfig.json").write_text('{"typeCheckingMode": "strict"}')
    command = [sys.executable, "-m", "pyright", "--pythonpath", str(environment.python), script.name]
    return subprocess.run(command, cwd=script.parent, capture_output=True, text=True)


CHECKERS = [
    _mypy,
    pytest.param(
        _pyright, marks=pytest.mark.skipif(shutil.which("node") is None, reason="pyright needs node")
    ),
]


@pytest.mark.parametrize("check", CHECKERS)
def test_a_typed_script_passes_its_checker(check: Check, environment: Environment, tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(TYPED)
    done = check(environment, script)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("check", CHECKERS)
def test_wrong_types_are_found(check: Check, environment: Environment, tmp_path: Path) -> None:
    text = TYPED
    for right, wrong in WRONG.items():
        text = text.replace(right, wrong)
    script = tmp_path / "script.py"
    script.write_text(text)
    done = check(environment, script)
    assert done.returncode == 1, done.stdout + done.stderr
    for number, line in enumerate(text.splitlines(), 1):
        assert (f"script.py:{number}:" in done.stdout) == any(wrong in line for wrong in WRONG.values()), (
            done.stdout
        )


def test_a_checkout_without_links_says_what_to_do(tmp_path: Path) -> None:
    source = copy_sources(tmp_path / "source")
    link = source / "src" / "primfit" / "fitting"
    link.unlink()
    link.write_text("../../fitting")
    command = [sys.executable, "-m", "pip", "wheel", *OFFLINE, "--wheel-dir", str(tmp_path), str(source)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode != 0
    assert "git clone --config core.symlinks=true" in done.stderr
