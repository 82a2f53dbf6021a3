"""The commands and programs of docs/clients.md run as they stand, but for the address of the service."""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.paths import DOCS, ROOT

BLOCK = re.compile(r"^```(sh|python)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
BLOCKS = BLOCK.findall((DOCS / "clients.md").read_text())


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder where the commands find what they name, and may write."""
    folder = tmp_path_factory.mktemp("checkout")
    for name in ("app", "docs", "tests"):
        (folder / name).symlink_to(ROOT / name)
    return folder


@pytest.mark.parametrize(
    ("language", "block"), BLOCKS, ids=[f"{i}-{block[0]}" for i, block in enumerate(BLOCKS)]
)
def test_a_block_runs_as_it_stands(service: Any, checkout: Path, language: str, block: str) -> None:
    block = block.replace("http://127.0.0.1:8000", f"http://127.0.0.1:{service.port}")
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    command = ["bash", "-euc", block] if language == "sh" else [sys.executable, "-c", block]
    done = subprocess.run(
        command, cwd=checkout, env={**os.environ, "PATH": path}, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "urn:primfit:problem" not in done.stdout
