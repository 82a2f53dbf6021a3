"""The process in which methods run: started by `benchmark.runner`, asked over a socket, ended by it.

Requests and replies are dicts of plain values. A method is loaded on its first request: imported,
constructed, and shown one small cloud of each kind that it can answer, so that it is warm when time is
measured.
"""

import gc
import os
import platform
import resource
import sys
import time
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives import PRIMITIVES, parameters
from primfit.synthetic import BenchmarkRecipe, cloud
from primfit.synthetic.recipes import KINDS

from . import sources
from .methods import METHODS, NETWORKS, PAPER, Answer, Method, load

MEMORY_SHARE = 0.75
"""Of the machine's memory, that a method may take before it gets a `MemoryError`."""
WARM_UP_SEED = 0
NOTE = 300
"""Characters that are kept of an error."""


def main() -> None:
    """Serve requests on the file descriptor that is the first argument, until its other end is closed."""
    limit_memory()
    stay_on_one_processor()
    connection: Connection[Any, Any] = Connection(int(sys.argv[1]))
    while True:
        try:
            request = connection.recv()
        except EOFError:
            return
        connection.send(reply(**request))


def stay_on_one_processor() -> None:
    """One thread at a time for libraries that read no environment variable, too, where the system can."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def limit_memory() -> None:
    total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    resource.setrlimit(resource.RLIMIT_DATA, (int(MEMORY_SHARE * total), resource.RLIM_INFINITY))


def reply(method: str, points: bytes | None = None, kind: str | None = None) -> dict[str, Any]:
    """What a method is, or, given points (float64, C order, three a point), what it answers."""
    if points is None:
        return introduce(method)
    return ask(warm(method), np.frombuffer(bytearray(points)).reshape(-1, 3), kind)


@cache
def warm(name: str) -> Method:
    method = load(name)
    for index, kind in enumerate(KINDS):
        if kind in method.kinds:
            small = cloud(BenchmarkRecipe(WARM_UP_SEED, perturbations=("A3",)), index).points
            ask(method, small, None if method.decides_kind else kind)
    return method


def ask(method: Method, points: Array, kind: str | None) -> dict[str, Any]:
    """The fields of `benchmark.records.Outcome`; whatever is raised is a value of the status `error`."""
    gc.collect()
    started, started_cpu = time.perf_counter(), time.process_time()
    try:
        answer: Answer | BaseException = method.fit(points, kind)
    except BaseException as error:  # some bindings raise what is no Exception
        answer = error
    spent = {
        "seconds": time.perf_counter() - started,
        "cpu_seconds": time.process_time() - started_cpu,
    }
    if isinstance(answer, BaseException):
        return spent | {"status": "error", "note": f"{type(answer).__name__}: {answer}"[:NOTE]}
    return spent | described(answer)


def described(answer: Answer) -> dict[str, Any]:
    """An answer in plain values; one that is not finite is an error."""
    primitive = parameters(answer.primitive) if answer.primitive is not None else None
    numbers = [value for name, value in (primitive or {}).items() if name != "kind"]
    if numbers and not np.isfinite(np.hstack(numbers)).all():
        return {"status": "error", "note": f"parameters that are not finite: {primitive}"[:NOTE]}
    return {
        "status": answer.status,
        "primitive": primitive,
        "note": answer.note,
        "attempts": tuple(answer.attempts),
        "alternatives": tuple(answer.alternatives),
        "normals_seconds": answer.normals_seconds,
    }


def introduce(name: str) -> dict[str, Any]:
    """What `benchmark.methods.Method` says, and versions; or, under `missing`, why it cannot be loaded."""
    try:
        method = warm(name)
    except ImportError as error:
        return {"missing": str(error)}
    return {
        "package": method.package,
        "decides_kind": method.decides_kind,
        "kinds": [kind for kind in PRIMITIVES if kind in method.kinds],
        "settings": method.settings,
        "versions": versions(method),
        "machine": f"{processor()}, {platform.system()}",
    }


def versions(method: Method) -> dict[str, str]:
    """Of the package and what it runs on; `source` tells one state of primfit's own code from another."""
    networks = ["torch"] if method.name in NETWORKS else []
    packages = dict.fromkeys([method.package, "numpy", "scipy", *networks])
    found = {name: installed(name) for name in packages} | {"python": platform.python_version()}
    module = METHODS[method.name].partition(":")[0].removeprefix("primfit.").replace(".", "/")
    files = [sources.ROOT / f"{module}.py"]
    files += sources.own_files() if method.package == "primfit" else []
    files += sources.paper_files(method.name) if method.name in PAPER else []
    return found | {"source": sources.digest(files)}


def installed(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"


def processor() -> str:
    """The processor's name where the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.machine())


if __name__ == "__main__":
    main()
