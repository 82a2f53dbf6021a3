"""Packages of npm for tests, by their lock files."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.paths import DOCS, ROOT

_BUILD = ROOT / "build" / "viewer" / os.environ.get("PYTEST_XDIST_WORKER", "alone")
VIEWER = _BUILD / "app" / "viewer"
"""A copy of the sources of the viewer; node_modules stay there from one run to the next."""
needs_node = pytest.mark.skipif(
    not (shutil.which("node") and shutil.which("npm")), reason="needs node and npm"
)
_OFFLINE = re.compile(
    r"E(NOTFOUND|CONNREFUSED|CONNRESET|AI_AGAIN|TIMEDOUT|HOSTUNREACH|NETUNREACH)|ERR_SOCKET"
)


def installed(folder: Path, lock: str) -> None:
    """Have the packages of `lock`, which stands in the folder, beside it; they stay for the next run."""
    note = folder / "installed.json"
    if note.exists() and note.read_text() == lock:
        return
    done = run(folder, "npm", "ci")
    if done.returncode and _OFFLINE.search(done.stderr):
        pytest.skip("npm ci reaches no registry")
    assert done.returncode == 0, done.stderr
    note.write_text(lock)


def run(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)


def succeed(folder: Path, *command: str) -> str:
    """What a command prints; it must not fail."""
    done = run(folder, *command)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def install_viewer() -> None:
    """Have the sources of the viewer, and the packages of their lock file, in `VIEWER`."""
    source = ROOT / "app" / "viewer"
    shutil.rmtree(VIEWER / "src", ignore_errors=True)
    shutil.copytree(source / "src", VIEWER / "src")
    for path in source.iterdir():
        if path.is_file():
            shutil.copy(path, VIEWER)
    (_BUILD / "docs").mkdir(parents=True, exist_ok=True)
    shutil.copy(DOCS / "openapi.json", _BUILD / "docs")
    installed(VIEWER, (source / "package-lock.json").read_text())
