"""The commands and programs of README and docs run as they stand, except for the port of a service.

A page is one session of a shell in a copy of the checkout: what a block makes is there for the next ones, and
a service that a line starts runs until the page ends. A block that cannot run here says why in a comment
above it, `<!-- not run: why -->`, and is listed as skipped. A command within a sentence is one that there is,
with options that it has; it runs, too, if it is whole and quick.
"""

import doctest
import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tomllib
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from typer.core import TyperGroup
from typer.main import get_command

from primfit.app.cli.commands import app
from primfit.benchmark.options import make_parser
from primfit.benchmark.scaling.command import ACTIONS
from tests.paths import DOCS, ROOT

FENCE = re.compile(r"(?:^<!-- not run: ([^\n]*) -->\n)?^( *)```(\w*)\n(.*?)^\2```$", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"^    (?:curl|primfit|make|pip|docker|python) ", re.MULTILINE)
"""A command outside of a block."""
IN_A_SENTENCE = re.compile(r"`(?:\.venv/bin/)?((?:primfit|make|python -m|pip install) [^`]+)`")
TO_TRY = re.compile(r"primfit (?:--show-completion|(?:fit|synth|openapi|settings) )[^A-Z*|.]*(?:\.\w+)?")
"""Those of them that are whole, and quick."""
STARTS = re.compile(r"^(?:make run|(?:\.venv/bin/)?primfit serve)\b")
"""A line that starts a service."""
ENDS_WITH = re.compile(r"^([^#]*?)\s*# exit status (\d+)$")
AT = re.compile(r"(?:127\.0\.0\.1|localhost):8000")

RUN = ("sh", "python")
NO_COMMANDS = ("js", "json", "promql", "pycon", "text", "toml", "ts")
"""Data; examples with their output; scripts of web pages; TypeScript, which
tests/app/test_typescript_client.py builds."""

PRELUDE = """set -eu -o pipefail
curl() { command curl --silent --show-error --fail-with-body "$@"; }
# Installing is for tests/test_installing.py; everything that comes after it runs.
make() { command make --old-file=setup "$@"; }
ready() { until command curl --silent --fail --output /dev/null http://127.0.0.1:8000/readyz
          do kill -0 $!; sleep 0.2; done; }
"""


@dataclass(frozen=True)
class Block:
    """A fenced block: its page and line, its language, its text, and why it is not run, if it is not."""

    page: str
    line: int
    language: str
    text: str
    excuse: str | None

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"

    def script(self) -> str:
        """The block as lines of a shell that echo where they stand."""
        if self.language == "python":
            lines = ["python - <<'END_OF_PROGRAM'", self.text.rstrip("\n"), "END_OF_PROGRAM"]
        else:
            lines = [_as_run(line) for line in self.text.splitlines()]
        return "\n".join([f"echo '-- {self}' >&2", *lines, ""])


def _as_run(line: str) -> str:
    """A line of a shell: a service stays in the background, an exit status is the one that is announced."""
    if STARTS.match(line):
        return f"{line.partition('#')[0].rstrip(' &')} > service.log 2>&1 &\nready"
    if announced := ENDS_WITH.match(line):
        command, status = announced.groups()
        return f"ended=0; {command} || ended=$?; test $ended -eq {status}"
    return line


def _blocks(path: Path) -> list[Block]:
    text, page = path.read_text(), str(path.relative_to(ROOT))
    found = []
    for match in FENCE.finditer(text):
        excuse, indent, language, content = match.groups()
        line = text.count("\n", 0, match.start(3)) + 1
        found.append(
            Block(page, line, language, re.sub(f"^{indent}", "", content, flags=re.MULTILINE), excuse)
        )
    return found


def _generated(path: Path) -> bool:
    """Whether `primfit bench report` writes the page: its commands are the benchmark's and take hours."""
    return "<!-- Written by `primfit bench report`" in path.read_text()


PYTHON_PAGE = "docs/python.md"
"""tests/app/test_python_docs.py runs its examples."""
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "SECURITY.md", ROOT / "samples" / "README.md"]
PAGES += [path for path in sorted(DOCS.glob("*.md")) if not _generated(path)]
BLOCKS = {path: _blocks(path) for path in PAGES}
TO_RUN = {
    path: runnable
    for path, blocks in BLOCKS.items()
    if (runnable := [block for block in blocks if block.language in RUN and block.excuse is None])
}


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_commands_stand_in_blocks_of_a_known_language(path: Path) -> None:
    unknown = [str(b) for b in BLOCKS[path] if b.language not in (*RUN, *NO_COMMANDS) and b.excuse is None]
    assert not unknown
    assert not COMMAND.findall(FENCE.sub("", path.read_text()))
    assert path.read_text().count("```") == 2 * len(BLOCKS[path])


@pytest.mark.parametrize("block", [b for blocks in BLOCKS.values() for b in blocks if b.excuse], ids=str)
def test_a_block_that_is_not_run_says_why(block: Block) -> None:
    assert block.excuse
    pytest.skip(block.excuse)


EXAMPLES = [
    b for blocks in BLOCKS.values() for b in blocks if b.language == "pycon" and b.page != PYTHON_PAGE
]


@pytest.mark.parametrize("block", EXAMPLES, ids=str)
def test_an_example_prints_what_stands_there(block: Block) -> None:
    example = doctest.DocTestParser().get_doctest(block.text, {}, str(block), block.page, block.line)
    doctest.DebugRunner().run(example)


BRITISH = re.compile(
    r"\b(?:optimis|minimis|normalis|recognis|colour|centre|metre|millimetre|artefact|behaviour)\w*",
    re.IGNORECASE,
)


@pytest.mark.parametrize("path", [ROOT / "README.md", ROOT / "CHANGELOG.md", *DOCS.glob("*.md")], ids=str)
def test_prose_is_american_and_percent_signs_follow_their_numbers(path: Path) -> None:
    prose = re.sub(r"`[^`]*`", "", FENCE.sub("", path.read_text()))
    assert not re.findall(r"[0-9] %.{0,20}", prose)
    assert not BRITISH.findall(prose)


SENTENCES = {
    " ".join(command.split())
    for path in PAGES
    for command in IN_A_SENTENCE.findall(FENCE.sub("", path.read_text()))
}


def _is_known(command: Any, words: list[str]) -> bool:
    """Whether a command of typer, or the one below it that is named, has all options that are given."""
    while words and (below := getattr(command, "commands", {}).get(words[0])):
        command, words = below, words[1:]
    options = {name for each in command.params for name in each.opts} | {"-h", "--help", "--version"}
    if not isinstance(command, TyperGroup):
        return {word for word in words if word.startswith("-")} <= options
    return all(word.startswith("--") and word.endswith("-completion") for word in words[:1])


def _parses(words: list[str]) -> bool:
    """Whether `primfit bench` takes these words."""
    nothing = [lambda _options: 0] * 9
    with pytest.raises(SystemExit) as ended:
        make_parser("primfit bench", *nothing, ACTIONS).parse_args(words)
        raise SystemExit(0)
    return ended.value.code == 0


@pytest.mark.parametrize("sentence", sorted(SENTENCES))
def test_a_command_in_a_sentence_is_one_that_there_is(sentence: str) -> None:
    named = sentence.replace("COMMAND", "fit").partition(" > ")[0].partition(" | ")[0]
    program, *words = shlex.split(named)
    if program == "make":
        targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
        assert {word for word in words if "=" not in word} <= targets
    elif program == "python":
        assert find_spec(words[1])
    elif program == "pip":
        project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
        extras = {extra for word in words for extra in re.findall(r"(?:primfit|\.)\[(.*)\]", word)}
        assert extras <= project["optional-dependencies"].keys()
    elif words[0] == "bench":
        assert _parses(words[1:])
    else:
        assert _is_known(get_command(app), words)


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A folder where commands find what they name, with the running environment as `.venv`, and may write."""
    for path in ROOT.iterdir():
        if path.name not in (".git", ".venv", "build", "dist"):
            (tmp_path / path.name).symlink_to(path)
    (tmp_path / ".venv").symlink_to(sys.prefix)
    return tmp_path


def _free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def _run(script: str, folder: Path, port: int) -> tuple[int, str]:
    """Exit status and output of a script; whatever it has started ends with it."""
    variables = {"PRIMFIT_PORT": str(port), "PORT": str(port), "PRIMFIT_WORKERS": "1", "COLUMNS": "100"}
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    with (folder / "output.log").open("w+") as log:
        shell = subprocess.Popen(
            ["bash", "-c", AT.sub(f"127.0.0.1:{port}", script)],
            cwd=folder,
            env={**os.environ, **variables, "PATH": path},
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            status = shell.wait(timeout=300)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(shell.pid, signal.SIGKILL)
        return status, (folder / "output.log").read_text()


@pytest.mark.skipif(not shutil.which("bash"), reason="needs bash")
@pytest.mark.parametrize("command", sorted(filter(TO_TRY.fullmatch, SENTENCES)))
def test_a_whole_command_in_a_sentence_runs(command: str, checkout: Path) -> None:
    """Started by bash, which stays: completion looks for the shell that it was asked from."""
    status, output = _run(f"{PRELUDE}{command}\nexit $?", checkout, _free_port())
    assert status == 0, output[-4000:]


@pytest.mark.skipif(not shutil.which("bash") or not shutil.which("curl"), reason="needs bash and curl")
@pytest.mark.parametrize("path", TO_RUN, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_page_runs_as_it_stands(path: Path, checkout: Path, request: pytest.FixtureRequest) -> None:
    script = PRELUDE + "".join(block.script() for block in TO_RUN[path])
    starts_one = any(STARTS.match(line) for block in TO_RUN[path] for line in block.text.splitlines())
    asks = AT.search("".join(block.text for block in TO_RUN[path])) is not None
    port = request.getfixturevalue("service").port if asks and not starts_one else _free_port()
    status, output = _run(script, checkout, port)
    assert status == 0, output[-4000:]
