"""Fuzz every target, or those named, one after the other: `python -m tests.fuzz [--seconds S] [NAME ...]`.

Each begins with its seeds and with what is kept in `corpus/NAME`. What it finds on its way is in
`build/fuzz/NAME`; an input that breaks something, beside it. The report is a line a target.
"""

import argparse
import re
import subprocess
import sys
import time
from pathlib import Path

from tests.fuzz.seeds import SEEDS
from tests.fuzz.targets import TARGETS
from tests.paths import ROOT

BUILD = ROOT / "build" / "fuzz"
CORPUS = Path(__file__).with_name("corpus")
_LONGEST = 16 * 1024
"""Bytes of an input: what depends on size is in the list of hostile inputs, and short ones are many more."""

_MEMORY = 2048
"""Megabytes that end a process whose input never ends to take more."""


def fuzz(name: str, seconds: int) -> bool:
    """Whether nothing broke in these seconds."""
    found = BUILD / name
    found.mkdir(parents=True, exist_ok=True)
    for i, seed in enumerate(SEEDS[name]):
        (found / f"seed-{i}").write_bytes(seed)
    folders = [str(found), *(str(folder) for folder in (CORPUS / name,) if folder.exists())]
    flags = (f"-max_total_time={seconds}", f"-max_len={_LONGEST}", f"-rss_limit_mb={_MEMORY}", "-timeout=20")
    command = [sys.executable, "-m", "tests.fuzz.one", name, *folders, *flags]
    started = time.monotonic()
    log = BUILD / f"{name}.log"
    with log.open("w") as told:
        status = subprocess.run(
            [*command, f"-artifact_prefix={BUILD}/{name}-"], cwd=ROOT, stdout=told, stderr=told, check=False
        ).returncode
    seconds_taken = time.monotonic() - started
    result = "nothing broke" if status == 0 else f"BROKEN: see {log}"
    print(f"{name}: {seconds_taken:.0f} s, {_figures(log.read_text('latin-1'))}: {result}", flush=True)
    return status == 0


def _figures(log: str) -> str:
    """What libFuzzer told last: how many inputs it tried, what they reached, how many it kept."""
    told = re.findall(r"^#(\d+)\s.*?cov: (\d+) ft: (\d+) corp: (\d+)", log, re.MULTILINE)
    if not told:
        return "nothing tried"
    words = zip(told[-1], ("executions", "branches", "features", "inputs kept"), strict=True)
    return ", ".join(f"{number} {what}" for number, what in words)


def main() -> None:
    parser = argparse.ArgumentParser(description="Fuzz the readers, coverage-guided.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(TARGETS)}; all by default")
    parser.add_argument("--seconds", type=int, default=120, help="for each")
    given = parser.parse_args()
    results = [fuzz(name, given.seconds) for name in given.names or TARGETS]
    sys.exit(not all(results))


if __name__ == "__main__":
    main()
