"""Runs methods over cases, one cloud after the other, the methods taking turns.

Methods live in a child process on one thread. It is killed when an answer takes too long and started again
when it is gone, so that a hang or a crash costs one record; the records are written here.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from multiprocessing import Pipe
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from primfit.fitting.primitives.primitive import Primitive

from .cases import Case
from .methods import NETWORKS, PAPER, PEERS
from .records import Outcome, Record, RecordsFile, Scored
from .sources import ROOT

THREADS = ("OMP", "OPENBLAS", "MKL", "RAYON", "NUMEXPR", "NUMBA", "TBB")
"""Each with `_NUM_THREADS`: how libraries are told to stay on one thread."""

LOADING = 300.0
"""Seconds after which a method that is still loading counts as hanging."""

GRACE = 0.5
"""Seconds that the process gets to end by itself."""


class Hang(Exception):
    """No reply within the limit."""


class Crash(Exception):
    """The process ended."""


class MethodError(ValueError):
    """A method that was asked for cannot be used."""


@dataclass
class Child:
    """A process that runs methods; started when it is first asked, and again after a hang or a crash.

    Attributes
    ----------
    python : its interpreter
    log : file that takes what methods print
    program : what it runs; the file descriptor of its connection follows
    """

    python: Path
    log: Path
    program: tuple[str, ...] = ("-m", "primfit.benchmark.child")
    process: subprocess.Popen[bytes] | None = None
    connection: Any = None
    loaded: dict[str, dict[str, Any]] = field(default_factory=dict)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop()

    def introduction(self, method: str) -> dict[str, Any]:
        """What `benchmark.child.introduce` says, the method being warm; raises `Hang` or `Crash`."""
        if method not in self.loaded:
            self.loaded[method] = self.ask({"method": method}, LOADING)
        return self.loaded[method]

    def fit(self, method: str, case: Case, kind: str | None, timeout: float) -> Outcome:
        """What becomes of asking a method, whatever it does; `timeout` in seconds."""
        points = np.ascontiguousarray(case.points, np.float64).tobytes()
        try:
            self.introduction(method)
            return Outcome(**self.ask({"method": method, "points": points, "kind": kind}, timeout))
        except Hang as hang:
            return Outcome("timeout", note=str(hang), seconds=timeout)
        except Crash as crash:
            return Outcome("crash", note=str(crash))

    def ask(self, request: dict[str, Any], timeout: float) -> dict[str, Any]:
        if self.process is None:
            self.start()
        try:
            self.connection.send(request)
            if not self.connection.poll(timeout):
                self.stop()
                raise Hang(f"no answer within {timeout:g} s")
            reply: dict[str, Any] = self.connection.recv()
        except (EOFError, ConnectionError):
            raise Crash(self.stop()) from None
        return reply

    def start(self) -> None:
        self.connection, theirs = Pipe()
        environment = os.environ | {f"{name}_NUM_THREADS": "1" for name in THREADS}
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(
                [self.python, *self.program, str(theirs.fileno())],
                env=environment | {"PYTHONPATH": str(ROOT / "src"), "PYTHONHASHSEED": "0"},
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                start_new_session=True,
            )
        theirs.close()

    def stop(self) -> str:
        """End the process and what it started; returns how it had ended, if it had."""
        if self.process is None:
            return "it never ran"
        self.connection.close()
        try:
            self.process.wait(GRACE)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
        status = self.process.wait()
        self.process = None
        self.loaded.clear()
        return f"ended by {signal.Signals(-status).name}" if status < 0 else f"ended with status {status}"


@dataclass
class Children:
    """A child for each interpreter that methods need; what a `Child` does, by the one of the method.

    Attributes
    ----------
    log : as of `Child`
    python : the interpreter of all methods; by default each has its own
    """

    log: Path
    python: Path | None = None
    started: dict[Path, Child] = field(default_factory=dict)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for child in self.started.values():
            child.stop()

    def introduction(self, method: str) -> dict[str, Any]:
        return self.of(method).introduction(method)

    def fit(self, method: str, case: Case, kind: str | None, timeout: float) -> Outcome:
        return self.of(method).fit(method, case, kind, timeout)

    def of(self, method: str) -> Child:
        """The child that has this method."""
        python = self.python or interpreter(method)
        return self.started.setdefault(python, Child(python, self.log))


@dataclass(frozen=True)
class Work:
    """The cases of one set: their names, in order, and how each is drawn or read.

    `seed` tells them from other cases of the same names; that of a folder is a number made of its truths.
    Of an `own` set methods of others are not asked. `published` has answers that stand beside the cases, by
    the method's name in records and the name of the case.
    """

    set: str
    seed: int
    names: Sequence[str]
    draw: Callable[[str], Case]
    own: bool = False
    published: Mapping[str, Mapping[str, Primitive]] = field(default_factory=dict)


def interpreter(method: str) -> Path:
    """That of the environment of a peer or of a network where it is there, else the running one."""
    folder = ".venv-peers" if method in PEERS else ".venv-torch" if method in NETWORKS else None
    theirs = ROOT / folder / "bin" / "python" if folder else None
    return theirs if theirs and theirs.exists() else Path(sys.executable)


def introduce(child: Child | Children, methods: Sequence[str]) -> dict[str, dict[str, Any]]:
    """What each method says of itself; one that is not installed says so under `missing`.

    Raises
    ------
    MethodError : a method hangs or crashes before it is asked anything
    """
    known = {}
    for method in methods:
        try:
            known[method] = child.introduction(method)
        except (Hang, Crash) as failure:
            raise MethodError(f"{method} cannot be started ({failure}); see {child.log}") from None
    return known


def begin(
    file: RecordsFile, works: Sequence[Work], methods: dict[str, dict[str, Any]], restart: bool
) -> tuple[list[Record], int]:
    """Make a folder ready for a run.

    Returns
    -------
    The records that it goes on from, and the number of those that were dropped because the versions of their
    method have changed; with `restart` those that are asked for are dropped, too.
    """
    sets = {(work.set, work.seed) for work in works}
    before = list(file.read())
    fresh = [r for r in before if r.versions == methods.get(r.method, {}).get("versions", r.versions)]
    kept = [r for r in fresh if not (restart and r.method in methods and (r.set, r.seed) in sets)]
    file.rewrite(kept)
    file.describe(methods)
    return kept, len(before) - len(fresh)


def run(
    child: Child | Children,
    file: RecordsFile,
    works: Sequence[Work],
    methods: dict[str, dict[str, Any]],
    done: Sequence[Record],
    timeout: float,
) -> Iterator[tuple[Work, list[Record]]]:
    """Ask every method about every case that has no record yet; yields the new records of each case."""
    known = {record.key for record in done}
    kinds = {record.key[:3]: record.kind for record in done}
    for work in works:
        others = (*PEERS, *PAPER) if work.own else ()
        asked = {name: about for name, about in methods.items() if name not in others}
        for name in work.names:
            case = (work.set, work.seed, name)
            missing = [
                method
                for method, about in asked.items()
                if (*case, method) not in known and (case not in kinds or asked_about(about, kinds[case]))
            ]
            yield work, list(_run_case(child, file, work, name, missing, methods, timeout)) if missing else []


def asked_about(method: dict[str, Any], kind: str) -> bool:
    """Whether a method is asked about clouds of this kind: it finds the kind, or can be given this one."""
    return bool(method["decides_kind"]) or kind in method["kinds"]


def _run_case(
    child: Child | Children,
    file: RecordsFile,
    work: Work,
    name: str,
    missing: Sequence[str],
    methods: dict[str, dict[str, Any]],
    timeout: float,
) -> Iterator[Record]:
    scored = Scored(work.set, work.seed, work.draw(name))
    for method in missing:
        if not asked_about(methods[method], scored.case.kind):
            continue
        kind = None if methods[method]["decides_kind"] else scored.case.kind
        outcome = child.fit(method, scored.case, kind, timeout)
        record = scored.record(method, outcome, methods[method]["versions"])
        file.append(record)
        yield record
