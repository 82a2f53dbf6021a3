"""What a request costs: more than in another checkout, and more than reading and fitting alone.

`python -m tests.fire.cost BEFORE AFTER` starts a service from each of two checkouts and asks them in turns.
The compiled parts of both must be there (`python setup.py build_ext --inplace`).
"""

import argparse
import re
import socket
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

from primfit.benchmark.service import csv
from primfit.benchmark.serving import connect
from tests.app.serving import running
from tests.fire.load import request
from tests.fire.report import Report, reported
from tests.fire.traffic import CSV, points

SMALL = request("/fit", csv(points("cylinder", 300)), CSV)
N_REQUESTS, BLOCK = 2000, 20
"""Of each service, and in a row before it is the other's turn: what else the machine does meets both."""
MORE, ADDED = 0.2, 1.5
"""Milliseconds: bars for what a request may cost more than before, and more than reading and fitting."""
_HEAD = re.compile(rb"(?s:.*?)\r\ncontent-length: (?P<length>\d+)(?s:.*?)\r\n\r\n")
_STEPS = re.compile(rb"\b(?:read|fit);dur=([\d.]+)")


@contextmanager
def connected(folder: Path, *checkouts: Path) -> Iterator[list[socket.socket]]:
    """A connection each to services of these checkouts with one worker, which have answered already."""
    with ExitStack() as opened:
        services = [
            opened.enter_context(running(folder / f"bodies-{i}", code=path.resolve() / "src", workers=1))
            for i, path in enumerate(checkouts)
        ]
        connections = [opened.enter_context(connect(service.port)) for service in services]
        for connection in connections * 5:
            for _ in range(BLOCK):
                asked(connection)
        yield connections


def asked(connection: socket.socket) -> tuple[float, float]:
    """Milliseconds of the small request, and those of them beside reading and fitting."""
    started = perf_counter()
    connection.sendall(SMALL)
    answer = b""
    while not (found := _HEAD.match(answer)) or len(answer) < found.end() + int(found["length"]):
        piece = connection.recv(2**16)
        assert piece, "the service closed the connection"
        answer += piece
    milliseconds = 1e3 * (perf_counter() - started)
    head = found.group()
    assert head.startswith(b"HTTP/1.1 200 ")
    return milliseconds, milliseconds - sum(map(float, _STEPS.findall(head)))


def added(connection: socket.socket) -> np.ndarray:
    """Milliseconds beside reading and fitting (N_REQUESTS,)."""
    return np.array([asked(connection)[1] for _ in range(N_REQUESTS)])


def compared(before: socket.socket, after: socket.socket) -> tuple[np.ndarray, np.ndarray]:
    """What `asked` tells of requests to either (blocks, BLOCK, 2), asked in turns."""
    found: list[list[list[tuple[float, float]]]] = [[], []]
    for i in range(N_REQUESTS // BLOCK):
        for which in (0, 1) if i % 2 else (1, 0):
            connection = (before, after)[which]
            found[which].append([asked(connection) for _ in range(BLOCK)])
    return np.array(found[0]), np.array(found[1])


def interval(before: np.ndarray, after: np.ndarray) -> tuple[float, float]:
    """95% interval of the difference of the medians: blocks are drawn anew, both of a turn together."""
    rng = np.random.default_rng(0)
    drawn = rng.integers(0, len(before), (2000, len(before)))
    differences = [np.median(after[rows]) - np.median(before[rows]) for rows in drawn]
    low, high = np.quantile(differences, (0.025, 0.975))
    return float(low), float(high)


def compare(figures: Report, checkouts: list[Path]) -> None:
    with (
        TemporaryDirectory(prefix="primfit-fire-") as folder,
        connected(Path(folder), *checkouts) as connections,
    ):
        before, after = compared(*connections)
    figures.note("requests of each", before[..., 0].size)
    for i, what in enumerate(("a request", "beside reading and fitting")):
        medians = [float(np.median(times[..., i])) for times in (before, after)]
        low, high = interval(before[..., i], after[..., i])
        figures.note(f"{what}, before and after", [round(median, 3) for median in medians], "ms")
        figures.note(f"{what}, 95% interval of the difference", [round(low, 3), round(high, 3)], "ms")
        figures.at_most(f"{what}, difference", medians[1] - medians[0], MORE, "ms", clock=True)
    figures.at_most("beside reading and fitting", medians[1], ADDED, "ms", clock=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    given = parser.parse_args()
    with reported("cost") as figures:
        compare(figures, [given.before, given.after])
    sys.exit(1 if figures.missed else 0)


if __name__ == "__main__":
    main()
