"""Processes that share work: results in its order, what jobs raise, processes that end, chunks that suit."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from primfit.app.engine.team import HEAVIEST, LARGEST, LostWorkerError, Ready, Team, chunks

posix = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")


@pytest.mark.parametrize(
    ("sizes", "workers", "expected"),
    [
        ([], 2, []),
        ([10] * 3, 2, [1, 1, 1]),
        ([10] * 8, 2, [2, 2, 1, 1, 1, 1]),
        ([10] * 100, 1, [LARGEST] * 11 + [6, 3, 2, 1]),
        ([HEAVIEST] * 40, 1, [1] * 40),
        ([HEAVIEST // 3] * 60, 1, [3] * 19 + [2, 1]),
        ([10 * HEAVIEST, 1, 1, *[1] * 60], 1, [1, *[8] * 6, 7, 4, 2, 1]),
    ],
)
def test_chunks_are_few_jobs_fewer_where_they_are_large_and_at_the_end(
    sizes: list[int], workers: int, expected: list[int]
) -> None:
    jobs = list(range(len(sizes)))
    found = list(chunks(jobs, sizes, workers))
    assert [job for chunk in found for job in chunk] == jobs
    assert [len(chunk) for chunk in found] == expected


def squared(number: int) -> tuple[int, int]:
    time.sleep(0.02 / (1 + number))  # the last ones are the quickest
    return number**2, os.getpid()


@pytest.mark.parametrize("size", [1, 2, 3])
def test_results_come_in_the_order_of_the_work(size: int) -> None:
    with Team(size) as team:
        outcomes = [team.submit(squared, range(start, start + 3)) for start in range(0, 12, 3)]
        found = list(team.in_order([outcomes[0], Ready([(-1, 0)]), *outcomes[1:]]))
    assert [number for number, _ in found] == [0, 1, 4, -1, *(n**2 for n in range(3, 12))]
    processes = {process for _, process in found} - {0}
    assert processes == {os.getpid()} if size == 1 else os.getpid() not in processes and len(processes) > 1


def test_work_may_depend_on_the_results_of_earlier_work() -> None:
    with Team(2) as team:

        def outcomes() -> Iterator[object]:
            for square, _ in team.in_order((team.submit(squared, [n]) for n in range(4)), ahead=1):
                yield team.submit(squared, [square])

        assert [fourth for fourth, _ in team.in_order(outcomes())] == [0, 1, 16, 81]  # type: ignore[arg-type]


def test_one_process_does_the_work_when_its_result_is_wanted() -> None:
    done: list[int] = []
    with Team(1) as team:
        assert team.scratch() is None
        results = team.in_order([team.submit(done.append, [1, 2]), team.submit(done.append, [3])])
        assert done == []
        next(results)
        assert done == [1]


def written(folder: Path, number: int) -> None:
    (folder / "missing" / str(number)).write_text("")


@pytest.mark.parametrize("size", [1, 2])
def test_what_a_job_raises_is_raised_here(size: int, tmp_path: Path) -> None:
    with pytest.raises(OSError) as caught, Team(size) as team:
        list(team.in_order([team.submit(partial(written, tmp_path), [3])]))
    assert caught.value.filename == str(tmp_path / "missing" / "3") or size == 1


def ended(number: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@posix
def test_a_process_that_is_killed_ends_the_work_and_leaves_no_files() -> None:
    with pytest.raises(LostWorkerError, match="ended from outside"), Team(2) as team:
        scratch = team.scratch()
        assert scratch is not None
        scratch.write_text("points")
        list(team.in_order([team.submit(ended, [1]), team.submit(squared, [2])]))
    assert not scratch.parent.exists()


def killed_at(poison: int, number: int) -> int:
    if number == poison:
        os.kill(os.getpid(), signal.SIGKILL)
    return os.getpid()


def alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


@posix
@pytest.mark.parametrize("size", [1, 2])
def test_a_process_that_is_killed_costs_its_chunk_only(size: int) -> None:
    found, lost = [], 0
    with Team(size, apart=True) as team:
        for outcome in [team.submit(partial(killed_at, 3), range(n, n + 2)) for n in range(0, 12, 2)]:
            try:
                found += outcome.results()
            except LostWorkerError:
                lost += 1
    assert lost == 1 and len(found) == 10
    assert os.getpid() not in found
    assert size > 1 or len(set(found)) == 2


@posix
def test_a_process_that_is_killed_while_it_has_no_work_costs_nothing() -> None:
    with Team(1, apart=True) as team:
        [process] = team.submit(partial(killed_at, -1), [0]).results()
        os.kill(process, signal.SIGKILL)
        while alive(process):
            time.sleep(0.01)
        [other] = team.submit(partial(killed_at, -1), [0]).results()
    assert other != process


def test_one_process_may_be_apart() -> None:
    with Team(1, apart=True) as team:
        scratch = team.scratch()
        assert scratch is not None
        found = list(team.in_order(team.submit(squared, [n]) for n in range(4)))
    assert [number for number, _ in found] == [0, 1, 4, 9]
    assert len({process for _, process in found} - {os.getpid()}) == 1


SCRIPT = """
    import multiprocessing, os, signal, threading, time
    import numpy as np
    import primfit

    def interrupt():
        while len(multiprocessing.active_children()) < 2:
            time.sleep(0.01)
        time.sleep(0.5)
        os.killpg(os.getpgrp(), signal.SIGINT)

    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    print("started")
    if {interrupted}:
        threading.Thread(target=interrupt).start()
    rng = np.random.default_rng(0)
    points = rng.normal(size=({n} * 300, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    try:
        segments = primfit.fit_segments(points, np.repeat(np.arange({n}), 300), workers=2)
    except KeyboardInterrupt:
        print("interrupted")
    else:
        print(len(segments), {{segment.recognition.primitive.kind for segment in segments}})
    print(os.environ.get("OMP_NUM_THREADS"), os.path.basename(__file__))
"""


def run(folder: Path, n: int, interrupted: bool) -> tuple[list[str], str]:
    """What the script says and complains of, with so many segments."""
    file = folder / "script.py"
    file.write_text(textwrap.dedent(SCRIPT.format(n=n, interrupted=interrupted)))
    environment = {name: value for name, value in os.environ.items() if name != "OMP_NUM_THREADS"}
    done = subprocess.run(
        [sys.executable, str(file)],
        capture_output=True,
        text=True,
        env=environment,
        timeout=300,
        check=False,
        start_new_session=True,
    )
    return done.stdout.splitlines(), done.stderr


def test_a_script_needs_no_guard_and_is_run_once(tmp_path: Path) -> None:
    assert run(tmp_path, 6, False) == (["started", "6 {'sphere'}", "None script.py"], "")


@posix
def test_an_interrupt_stops_the_work_without_a_word_from_its_processes(tmp_path: Path) -> None:
    assert run(tmp_path, 20_000, True) == (["started", "interrupted", "None script.py"], "")
