"""What `make wheel` left in dist/, installed where there is no compiler and no source (make test-wheel)."""

import json
import os
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

from tests.installing import ROOT, Environment

WHEELS = sorted((ROOT / "dist").glob("primfit-*.whl"))
COMPILED = [*(ROOT / "fitting").glob("*/*.pyx"), *(ROOT / "models").glob("*.pyx")]
EXAMPLE = ROOT / "app" / "examples" / "request.json"

pytestmark = [
    pytest.mark.wheel,
    pytest.mark.skipif(not WHEELS, reason="dist/ holds no wheel: make wheel"),
]


def test_there_is_one_for_all_versions_of_python_and_old_systems() -> None:
    (wheel,) = WHEELS
    assert "-cp311-abi3-manylinux" in wheel.name


def test_it_keeps_to_the_stable_abi() -> None:
    command = [sys.executable, "-m", "abi3audit", "--strict", "--report", str(WHEELS[0])]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (report,) = json.loads(done.stdout)["specs"].values()
    names = {compiled["name"] for compiled in report["wheel"]}
    assert names == {f"{source.stem}.abi3.so" for source in COMPILED}


def test_the_sdist_holds_the_sources_and_no_tests() -> None:
    (sdist,) = (ROOT / "dist").glob("primfit-*.tar.gz")
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
        assert not [member.name for member in archive if member.issym() or member.islnk()]
    shared = [path for path in (ROOT / "fitting").glob("*/*") if path.suffix in (".h", ".pxd")]
    assert {f"src/primfit/{source.relative_to(ROOT)}" for source in [*shared, *COMPILED]} <= names
    assert not [name for name in names if name.startswith("tests")]


def test_it_fits_where_there_is_no_compiler_and_no_source(tmp_path: Path) -> None:
    environment = Environment(tmp_path / "environment")
    only = {"PATH": str(environment.scripts), "HOME": str(tmp_path), "OMP_NUM_THREADS": "1"}
    assert shutil.which("cc", path=only["PATH"]) is None
    environment.install("--only-binary", ":all:", str(WHEELS[0]), env=only)
    copied = shutil.copy(EXAMPLE, tmp_path)
    command = [str(environment.scripts / "primfit"), "fit", "--json", copied]
    answer = subprocess.run(command, cwd=tmp_path, env=only, check=True, capture_output=True).stdout
    assert answer == _answer_of_this_checkout(copied)


def _answer_of_this_checkout(file: str) -> bytes:
    command = [sys.executable, "-m", "primfit", "fit", "--json", file]
    return subprocess.run(
        command, check=True, capture_output=True, env=os.environ | {"OMP_NUM_THREADS": "1"}
    ).stdout
