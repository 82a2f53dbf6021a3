"""Help by either flag, completion in a real shell, and output for pipes."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from primfit.app.cli.commands import app
from tests.paths import EXAMPLES

COMMANDS = ("fit", "batch", "table", "serve", "mcp", "settings", "openapi", "jobs", "synth", "paper", "bench")
PRIMFIT = Path(sys.executable).with_name("primfit")


def _output(*words: str) -> str:
    result = CliRunner().invoke(app, list(words))
    assert result.stderr == ""
    return result.stdout


@pytest.mark.parametrize("command", [(), *((name,) for name in COMMANDS if name != "bench")], ids=" ".join)
def test_both_flags_show_the_help(command: tuple[str, ...]) -> None:
    shown = _output(*command, "-h")
    assert shown == _output(*command, "--help")
    assert shown.startswith("Usage: ")


def test_bench_has_a_help_of_its_own() -> None:
    for flag in ("-h", "--help"):
        done = subprocess.run([PRIMFIT, "bench", flag], capture_output=True, text=True, check=True)
        assert done.stdout.startswith("usage: primfit bench")


@pytest.mark.parametrize("words", [("--help",), ("fit", "--help"), ("fit", str(EXAMPLES / "cylinder.csv"))])
def test_lines_in_a_pipe_do_not_end_in_blanks(words: tuple[str, ...]) -> None:
    assert not re.search(r"[ \t]$", _output(*words), re.MULTILINE)


def test_a_long_line_in_a_pipe_is_not_wrapped() -> None:
    answer = _output("fit", str(EXAMPLES / "cylinder.csv"), "--kind", "sphere", "--kind", "plane")
    (status,) = (line for line in answer.splitlines() if line.startswith("no fit"))
    assert len(status) > 80 and status.endswith(".")


def test_each_file_that_is_written_is_told_apart() -> None:
    shown = re.sub(r"\s+", " ", _output("fit", "--help"))
    told = re.findall(r"--([\w-]+) <file> (Write [^.]*)\.", shown)
    assert len(told) == 13
    assert len({text for _, text in told}) == len(told)


@pytest.mark.skipif(
    not (shutil.which("bash") and PRIMFIT.exists()), reason="needs bash and the command primfit beside Python"
)
@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("primfit ba", ["batch"]),
        ("primfit fit --resid", [f"--residuals-{ending}" for ending in ("npy", "csv", "ply", "las")]),
        ("primfit fit --kind cy", ["cylinder"]),
        ("primfit fit --criterion minimum_", ["minimum_zone", "minimum_circumscribed"]),
        ("primfit batch --form", ["--form-tolerance", "--format"]),
    ],
)
def test_bash_completes(line: str, offered: list[str], tmp_path: Path) -> None:
    # As one types it in bash: Typer looks which shell it was started from.
    named = {**os.environ, "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    script = subprocess.run(
        [PRIMFIT, "--show-completion", "bash"], capture_output=True, text=True, check=True, env=named
    ).stdout
    script += f"COMP_WORDS=({line}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))\n"
    script += '_primfit_completion primfit; printf "%s\\n" "${COMPREPLY[@]}"\n'
    there = {**os.environ, "PATH": f"{PRIMFIT.parent}:{os.environ['PATH']}"}
    done = subprocess.run(
        ["bash", "--norc", "-c", script], capture_output=True, text=True, env=there, cwd=tmp_path
    )
    assert sorted(done.stdout.split()) == sorted(offered), done.stderr
