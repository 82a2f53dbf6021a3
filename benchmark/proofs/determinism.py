"""The same bytes give the same answer, whoever is asked: one process or eight, files or requests."""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from primfit.fitting.geometry.vectors import Array

from ..cases import CASE_SETS
from ..service import FORMATS
from ..serving import PATIENCE, ServiceError, connect, post, serving
from .trial import Figures, Trial

CLOUDS = 20
"""In one case, of one format: half of them of either set."""
SETS = ("scanner", "shrec")
WORKERS = (1, 8)
AT_ONCE = 8
TIMES = 2
"""Connections that ask at the same time, and how often each cloud is asked for."""

Answers = Sequence[bytes]


def draw(seed: int, index: int) -> Trial:
    """A format in turn, and clouds that no other case has."""
    format = tuple(FORMATS)[index % len(FORMATS)]
    numbers = range(index * CLOUDS // 2, (index + 1) * CLOUDS // 2)
    clouds = [CASE_SETS[name].draw(seed, number).points for number in numbers for name in SETS]
    media_type, write = FORMATS[format]
    about = f"{CLOUDS} clouds as {format}: {numbers[0]} to {numbers[-1]} of {' and '.join(SETS)}"
    return Trial({"format": format}, about, partial(compare, format, media_type, write, clouds))


def compare(
    format: str, media_type: str, write: Callable[[Array], bytes], clouds: Sequence[Array]
) -> Figures:
    """How many answers differ in a byte: of batches, of services, and of a service from a batch.

    There are no files of JSON: a batch has those clouds as NPY, and answers for other bytes.
    """
    bodies = [write(points) for points in clouds]
    suffix = "npy" if format == "json" else format
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "clouds").mkdir()
        for number, points in enumerate(clouds):
            (folder / "clouds" / f"{number}.{suffix}").write_bytes(FORMATS[suffix][1](points))
        one, eight = (_batch(folder, len(bodies), workers) for workers in WORKERS)
        asked = [_service(folder, media_type, bodies, workers) for workers in WORKERS]
    services = [
        len({answers[number] for served in asked for answers in served}) > 1 for number in range(len(bodies))
    ]
    figures = {"batch": float(_differing(one, eight)), "service": float(sum(services))}
    if suffix == format:
        figures["service beside batch"] = float(_differing(one, asked[0][0]))
    return figures


def _differing(some: Answers, others: Answers) -> int:
    return sum(one != other for one, other in zip(some, others, strict=True))


def _batch(folder: Path, count: int, workers: int) -> Answers:
    """The lines that `primfit batch` writes, in the order of the clouds."""
    out = folder / f"answers-{workers}"
    command = [sys.executable, "-m", "primfit", "batch", str(folder / "clouds"), "--out", str(out)]
    done = subprocess.run([*command, "--workers", str(workers)], capture_output=True, text=True)
    if done.returncode != 0:
        raise ServiceError(f"primfit batch ended with {done.returncode}: {done.stderr[-200:]}")
    return [(out / f"{number}.json").read_bytes().removesuffix(b"\n") for number in range(count)]


def _service(folder: Path, media_type: str, bodies: Sequence[bytes], workers: int) -> list[Answers]:
    """What a service answers, all bodies at once and several times, each from another connection."""
    with serving(folder / "service.log", workers) as served, ThreadPoolExecutor(AT_ONCE) as pool:
        answers = list(pool.map(partial(_one, served.port, media_type), [*bodies] * TIMES))
    return [answers[turn * len(bodies) : (turn + 1) * len(bodies)] for turn in range(TIMES)]


def _one(port: int, media_type: str, body: bytes) -> bytes:
    with connect(port) as connection:
        connection.settimeout(PATIENCE)
        return post(connection, media_type, body)
