"""Answers where standard output lacks some of their signs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.paths import EXAMPLES


@pytest.mark.parametrize(
    ("encoding", "diameter", "area"),
    [("ascii", " +- ", "mm^2"), ("cp1252", " \u00b1 ", "mm\u00b2"), ("utf-8", " \u00b1 ", "mm\u00b2")],
)
def test_signs_that_an_encoding_lacks_are_spelt_out(
    encoding: str, diameter: str, area: str, tmp_path: Path
) -> None:
    file = tmp_path / "\u7ba1.csv"
    file.write_bytes((EXAMPLES / "cylinder.csv").read_bytes())
    done = subprocess.run(
        [sys.executable, "-m", "primfit", "fit", "--unit", "mm", str(file)],
        capture_output=True,
        env={**os.environ, "PYTHONIOENCODING": encoding},
    )
    said = done.stdout.decode(encoding)
    assert (done.returncode, done.stderr) == (0, b"")
    assert diameter in said and area in said
    assert ("\u7ba1.csv" if encoding == "utf-8" else "?.csv") in said
