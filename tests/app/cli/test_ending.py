"""How commands end that are cut short: a reader that leaves, and Ctrl-C."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.paths import EXAMPLES

PATIENCE = 60.0
CLOUD = str(EXAMPLES / "cylinder.csv")
# It listens to an interrupt also where a shell has its background jobs ignore it.
COMMAND = [
    sys.executable,
    "-c",
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    "from primfit.app.cli.commands import main; main()",
]

pytestmark = pytest.mark.skipif(os.name != "posix", reason="pipes and signals are those of POSIX")


def _without_reader(*words: str) -> subprocess.CompletedProcess[str]:
    """A command whose standard output nobody reads any more."""
    reading, writing = os.pipe()
    os.close(reading)
    try:
        return subprocess.run(
            [*COMMAND, *words], stdout=writing, stderr=subprocess.PIPE, text=True, timeout=PATIENCE
        )
    finally:
        os.close(writing)


@pytest.mark.parametrize(
    "words",
    [
        ["fit", "--json", CLOUD, CLOUD],
        ["fit", CLOUD, CLOUD],
        ["openapi"],
        ["settings"],
        ["settings", "--markdown"],
        ["fit", "--help"],
        ["bench", "--help"],
        ["--help"],
    ],
    ids=" ".join,
)
def test_a_reader_that_leaves_is_no_fault(words: list[str]) -> None:
    done = _without_reader(*words)
    assert (done.returncode, done.stderr) == (0, "")


def test_what_is_to_be_written_is_there_though_the_reader_left(tmp_path: Path) -> None:
    report, table = tmp_path / "report.html", tmp_path / "all.csv"
    assert _without_reader("fit", CLOUD, "--report", str(report)).returncode == 0
    words = ("--out", str(tmp_path / "out"), "--table", str(table), "--workers", "1")
    _without_reader("batch", CLOUD, *words)
    assert report.stat().st_size > 1000 and table.read_text().count("\n") == 2


def test_the_lines_up_to_then_are_whole() -> None:
    process = subprocess.Popen(
        [*COMMAND, "fit", "--json", *[CLOUD] * 40], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout is not None and process.stderr is not None
    line = process.stdout.readline()
    process.stdout.close()
    assert line.startswith(b'{"status":"fitted"') and line.endswith(b"}\n")
    assert process.stderr.read() == b""
    assert process.wait(PATIENCE) == 0
    process.stderr.close()


def test_an_interrupted_fit_ends_with_one_line(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [*COMMAND, "fit", "--json", *[CLOUD] * 5000],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=tmp_path,
    )
    assert process.stdout is not None
    process.stdout.readline()
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=PATIENCE)
    assert (process.returncode, said) == (130, b"primfit: fit: interrupted\n")


@pytest.mark.parametrize("loaded", ["typer", "primfit.app.cli.options"])
def test_ctrl_c_while_the_program_is_loaded_is_one_line(loaded: str) -> None:
    program = f"""
import sys
class Pressed:
    def find_spec(self, name, *_):
        if name == {loaded!r}:
            raise KeyboardInterrupt
sys.meta_path.insert(0, Pressed())
from primfit.__main__ import main
main()
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=PATIENCE)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "primfit: interrupted\n")
