"""Packages of npm for tests, by their lock files."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

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
