"""Python clients as openapi-python-client generates them from an OpenAPI document."""

import importlib
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType


@contextmanager
def generated_client(document: bytes, name: str, directory: Path) -> Iterator[ModuleType]:
    """The package of this name, generated into a folder and imported."""
    source = directory / "openapi.json"
    source.write_bytes(document)
    config = directory / "config.yaml"
    config.write_text("post_hooks: []\n")
    command = [sys.executable, "-m", "openapi_python_client", "generate", "--meta", "none"]
    command += ["--path", str(source), "--config", str(config), "--output-path", str(directory / name)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    sys.path.insert(0, str(directory))
    yield importlib.import_module(name)
    sys.path.remove(str(directory))
