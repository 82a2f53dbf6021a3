"""A run that is killed by SIGKILL at each of its dealings with the disk, one after the other, and goes on.

`python killed.py FOLDER`: prints a line of JSON for each run: where it was killed, and how it ended.
"""

import json
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from primfit.app.bulk import parts
from primfit.app.bulk.parts import Run, part_file
from primfit.app.bulk.refs import Ref
from primfit.app.bulk.rows import problem_row, schema
from primfit.app.bulk.tasks import Task
from primfit.app.engine.answer import versions
from primfit.models.names import CLASSIFIER

EVENTS = frozenset(("open", "os.rename", "os.remove", "os.rmdir", "os.mkdir"))
N_TASKS = 4


class Countdown:
    """Ends the process at the n-th dealing with a file in a folder: before it takes place."""

    def __init__(self, folder: Path, n: int) -> None:
        self.left, self._folder = n, str(folder)
        sys.addaudithook(self)

    def __call__(self, event: str, args: tuple[Any, ...]) -> None:
        if event in EVENTS and str(args[0]).startswith(self._folder):
            if self.left == 0:
                os.kill(os.getpid(), signal.SIGKILL)
            self.left -= 1


def refs_of(number: int) -> tuple[Ref, ...]:
    return tuple(Ref(f"a.las#{3 * number + i}", "a.las", 3 * number + i, 100) for i in range(3))


def tasks(scratch: Path) -> Iterator[Task]:
    for number in range(N_TASKS):
        (scratch / f"store-{number}").write_bytes(b"points")
        yield Task(number, refs_of(number))


def work(out: Path, told: Path) -> None:
    """The whole run; each task that is done is told outside of its folder."""
    run = Run.begin(out, {"names": ["a.las"]}, {"seed": 1}, tasks)
    for task in run.due():
        with told.open("a") as log:
            log.write(f"{task.number}\n")
        assert (run.scratch / f"store-{task.number}").read_bytes() == b"points"
        run.finished(task, run.writer.write(task, [problem_row(ref, "no points") for ref in task.refs]))
    run.end()


def tree(out: Path) -> dict[str, str]:
    """All there is in a folder."""
    files = sorted(file for file in out.rglob("*") if file.is_file())
    return {str(file.relative_to(out)): file.read_bytes().hex() for file in files}


def in_a_process(out: Path, told: Path, n: int) -> bool:
    """Run, and be killed at the n-th dealing; whether the end was reached."""
    child = os.fork()
    if child == 0:
        try:
            Countdown(out, n)
            work(out, told)
        except BaseException as error:
            print(f"{error!r}", file=sys.stderr)
            os._exit(1)
        os._exit(0)
    status = os.waitpid(child, 0)[1]
    if os.WIFSIGNALED(status):
        assert os.WTERMSIG(status) == signal.SIGKILL
        return False
    assert os.WEXITSTATUS(status) == 0
    return True


def told_by(told: Path) -> list[int]:
    return list(map(int, told.read_text().split())) if told.exists() else []


def main(folder: Path) -> None:
    parts.SAVED_EVERY = 0.0 if "often" in sys.argv else 3600.0
    (folder / "told").mkdir(parents=True)
    # What every process needs is there before they are made.
    versions(CLASSIFIER)
    schema()
    import pyarrow.parquet

    pyarrow.Table.from_pylist([{}], schema=schema())

    assert in_a_process(folder / "whole", folder / "told" / "whole", 10**9)
    whole, n, ended = tree(folder / "whole"), 0, False
    while not ended:
        out, told = folder / f"killed-{n}", folder / "told" / str(n)
        ended = in_a_process(out, told, n)
        finished = [number for number in range(N_TASKS) if part_file(out, number).exists()]
        before = len(told_by(told))
        # Killed once more on its way, then left alone.
        ended_again = in_a_process(out, told, n // 2)
        assert in_a_process(out, told, 10**9)
        again = set(finished) & set(told_by(told)[before:])
        print(
            json.dumps(
                {"n": n, "same": tree(out) == whole, "again": sorted(again), "ended": [ended, ended_again]}
            )
        )
        n += 1


if __name__ == "__main__":
    main(Path(sys.argv[1]))
