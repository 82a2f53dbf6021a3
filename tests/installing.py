"""Environments to install primfit into: the dependencies are those of the running one, unfetched."""

import shutil
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Mapping
from pathlib import Path

from tests.paths import ROOT

HOUSES = ("app", "benchmark", "fitting", "models", "synthetic")
OFFLINE = ["--quiet", "--no-deps", "--no-build-isolation", "--no-index"]


def copy_sources(target: Path) -> Path:
    """The sources, in a new folder, so that the working tree stays as it is; they are compiled quickly."""
    target.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE", "MANIFEST.in"):
        shutil.copyfile(ROOT / name, target / name)
    (target / "setup.py").write_text((ROOT / "setup.py").read_text().replace('"-O3"', '"-O0"'))
    unwanted = shutil.ignore_patterns("__pycache__", "*.so", "*.egg-info", "_*.c")
    for name in ("src", *HOUSES, "paper"):
        shutil.copytree(ROOT / name, target / name, symlinks=True, ignore=unwanted)
    return target


def build_wheel(source: Path, folder: Path) -> Path:
    """The wheel of these sources, in this folder."""
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", *OFFLINE, "--wheel-dir", str(folder), str(source)], check=True
    )
    (built,) = folder.glob("primfit-*.whl")
    return built


class Environment:
    """A fresh virtual environment in this folder: the dependencies of the running one, without primfit."""

    def __init__(self, folder: Path) -> None:
        venv.create(folder, symlinks=True)
        self.scripts = folder / ("Scripts" if sys.platform == "win32" else "bin")
        self.python = self.scripts / Path(sys.executable).name
        paths = {"base": str(folder), "platbase": str(folder)}
        self.packages = Path(sysconfig.get_path("purelib", "venv", paths))
        # In a folder named so no other .pth counts: an editable primfit of the running one stays out.
        (self.packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")

    def install(self, *what: str, env: Mapping[str, str] | None = None) -> None:
        """Install without looking anywhere else; with these variables, or those of the running process."""
        pip = [sys.executable, "-m", "pip", "--python", str(self.python), "install", "--ignore-installed"]
        subprocess.run([*pip, *OFFLINE, *what], check=True, env=env)

    def installed(self) -> set[str]:
        """The names of what lies in its folder of packages."""
        return {path.name for path in self.packages.iterdir()} - {"dependencies.pth", "__pycache__"}

    def run(self, *arguments: str, cwd: Path) -> str:
        """What its Python prints when called so."""
        command = [str(self.python), *arguments]
        return subprocess.run(command, cwd=cwd, check=True, stdout=subprocess.PIPE, text=True).stdout
