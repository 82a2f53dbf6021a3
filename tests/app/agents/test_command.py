"""`primfit mcp` without what it needs, and with places that are none."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest


def _ended(*arguments: str, without: str = "", **environment: str) -> tuple[int, str]:
    """Exit status and standard error of the command, where a package may be missing."""
    start = "from primfit.app.cli.commands import main; main()"
    hide = f"import sys; sys.modules[{without!r}] = None; " if without else ""
    done = subprocess.run(
        [sys.executable, "-c", hide + start, "mcp", *arguments],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=60,
        env=environment or None,
    )
    assert done.stdout == ""
    return done.returncode, done.stderr


@pytest.mark.parametrize("missing", ["mcp", "PIL"])
def test_without_the_extra_it_says_what_to_install(missing: str) -> None:
    said = "primfit: mcp: the Model Context Protocol needs an extra: pip install 'primfit[mcp]'\n"
    assert _ended(without=missing) == (2, said)


@pytest.mark.parametrize("flag", ["--root", "--output"])
def test_folders_have_to_be_there(flag: str, tmp_path: Path) -> None:
    status, said = _ended(flag, str(tmp_path / "none"))
    assert status == 2 and "none is no folder" in said


def test_others_are_let_in_with_keys_only() -> None:
    pytest.importorskip("mcp", reason="needs the extra mcp: pip install 'primfit[mcp]'")
    status, said = _ended("--http", "--host", "0.0.0.0", "--port", "0")
    assert status == 2 and "API keys are needed: set PRIMFIT_API_KEYS" in said


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals of POSIX")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["Ctrl-C", "SIGTERM"])
def test_a_signal_ends_it_while_it_waits_for_its_client(number: signal.Signals, tmp_path: Path) -> None:
    pytest.importorskip("mcp", reason="needs the extra mcp: pip install 'primfit[mcp]'")
    command = [sys.executable, "-m", "primfit", "mcp", "--workers", "1", "--root", str(tmp_path)]
    with subprocess.Popen(command, stdin=-1, stdout=-1, stderr=-1, text=True) as process:
        assert process.stdin is not None and process.stdout is not None and process.stderr is not None
        process.stdin.write('{"jsonrpc": "2.0", "id": 1, "method": "ping"}\n')
        process.stdin.flush()
        assert '"id":1' in process.stdout.readline()
        process.send_signal(number)
        assert process.wait(60) == 128 + number
        assert process.stderr.read().endswith("primfit: mcp: interrupted\n")
