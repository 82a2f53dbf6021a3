"""Benchmark clouds against the benchmark's own training set, as tables of quantiles:

    python -m primfit.synthetic.compare PATH/train_parameters.csv.gz [--n 800] [--seed 1]

The file has a line `id,n_points,label,parameters...` for each of the 46,000 training clouds, in blocks of
5,000 (A9: 1,000) of one perturbation type. It is only read.
"""

import argparse
import csv
import gzip
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.shrec22 import from_vector

from .recipes import KINDS, PERTURBATIONS, TRAINING_COUNTS
from .shrec import batch

Array = NDArray[np.float64]

LEVELS = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)
FULL = {kind: 8100 if kind == "torus" else 6400 for kind in KINDS}
GROUPS = {
    "nothing removed (A0-A2)": ("A0", "A1", "A2"),
    "undersampled (A3, A5, A6)": ("A3", "A5", "A6"),
    "part missing (A4, A7, A8)": ("A4", "A7", "A8"),
    "bump (A9)": ("A9",),
}


@dataclass(frozen=True)
class Entry:
    """What the training set's file says of a cloud."""

    size: int
    perturbation: str
    primitive: Primitive


def read_training_set(path: Path) -> Iterator[Entry]:
    """The clouds of the benchmark's training set, perturbation types by the place in the file."""
    types = np.repeat(PERTURBATIONS, TRAINING_COUNTS)
    with gzip.open(path, "rt", newline="") as file:
        rows = csv.reader(file)
        next(rows)
        for (_, size, label, *numbers), perturbation in zip(rows, types, strict=True):
            primitive = from_vector(int(label), [float(number) for number in numbers if number])
            yield Entry(int(size), str(perturbation), primitive)


def drawn(seed: int, n: int) -> Iterator[Entry]:
    """n synthetic clouds of each kind, of which only these facts are kept."""
    for cloud in batch(seed, n * len(KINDS)):
        assert cloud.primitive is not None
        yield Entry(len(cloud.points), cloud.perturbation, cloud.primitive)


def position(primitive: Primitive) -> Array:
    """The point that the truth file gives."""
    for name in ("point", "center", "apex"):
        if hasattr(primitive, name):
            return np.asarray(getattr(primitive, name), np.float64)
    raise TypeError(f"no position for {type(primitive).__name__}")


def upright(primitive: Primitive) -> bool:
    axis = getattr(primitive, "axis", None)
    return axis is not None and bool(abs(axis[2]) > 1.0 - 1e-9)


def at_origin(primitive: Primitive) -> bool:
    return bool(np.abs(position(primitive)).max() < 1e-9)


def parameter(name: str) -> Callable[[Primitive], float]:
    return lambda primitive: float(getattr(primitive, name))


def offset(primitive: Primitive) -> float:
    return abs(float(primitive.normal @ primitive.point))  # type: ignore[attr-defined]


def height(primitive: Primitive) -> float:
    """Coordinate z of the position: it carries the extents along the axis."""
    return abs(float(position(primitive)[2]))


def ratio(primitive: Primitive) -> float:
    """Where the minor radius lies between 0.5 and the major radius."""
    return (primitive.minor_radius - 0.5) / max(primitive.major_radius - 0.5, 1e-9)  # type: ignore[attr-defined]


MEASURES: tuple[tuple[str, str, Callable[[Primitive], float]], ...] = (
    ("plane", "distance from the origin", offset),
    ("sphere", "radius", parameter("radius")),
    ("cylinder", "radius", parameter("radius")),
    ("cone", "half-angle [deg]", lambda cone: float(np.degrees(cone.half_angle))),  # type: ignore[attr-defined]
    ("torus", "major radius", parameter("major_radius")),
    ("torus", "minor radius", parameter("minor_radius")),
    ("torus", "(minor - 0.5) / (major - 0.5)", ratio),
    ("sphere", "abs z of the moved", height),
    ("cylinder", "abs z of the moved", height),
    ("cone", "abs z of the moved", height),
    ("torus", "abs z of the moved", height),
)


def row(name: str, values: list[float]) -> str:
    return f"| {name} | " + " | ".join(f"{value:.4g}" for value in np.quantile(values, LEVELS)) + " |"


def tables(entries: dict[str, list[Entry]]) -> Iterator[str]:
    """The report, line by line."""
    head = " | ".join(f"{100 * level:g}%" for level in LEVELS)
    yield f"| points | {head} | full grids |"
    yield "|---" * (len(LEVELS) + 2) + "|"
    for group, types in {"all types": PERTURBATIONS, **GROUPS}.items():
        for kind in KINDS:
            for source, clouds in entries.items():
                mine = [e for e in clouds if e.perturbation in types and e.primitive.kind == kind]
                sizes = [float(e.size) for e in mine]
                full = np.mean([size == FULL[kind] for size in sizes])
                yield f"{row(f'{kind}, {group}, {source}', sizes)} {100 * full:.1f}% |"
    yield ""
    yield f"| parameter | {head} |"
    yield "|---" * (len(LEVELS) + 1) + "|"
    for of, name, measure in MEASURES:
        for source, clouds in entries.items():
            mine = [e for e in clouds if e.primitive.kind == of]
            if "moved" in name:
                mine = [e for e in mine if not at_origin(e.primitive)]
            yield row(f"{of}: {name}, {source}", [measure(e.primitive) for e in mine])
    yield ""
    yield "| share of the clouds | axis exactly z | position exactly the origin |"
    yield "|---|---|---|"
    for kind in KINDS:
        for source, clouds in entries.items():
            mine = [e for e in clouds if e.primitive.kind == kind]
            up, still = (np.mean([test(e.primitive) for e in mine]) for test in (upright, at_origin))
            yield f"| {kind}, {source} | {100 * up:.1f}% | {100 * still:.1f}% |"


def main() -> None:
    parser = argparse.ArgumentParser(description="Synthetic clouds against the benchmark's training set.")
    parser.add_argument("path", type=Path, help="train_parameters.csv.gz of SHREC 2022")
    parser.add_argument("--n", type=int, default=800, help="synthetic clouds of each kind (default 800)")
    parser.add_argument("--seed", type=int, default=1, help="of the synthetic clouds (default 1)")
    options = parser.parse_args()
    entries = {
        "training set": list(read_training_set(options.path)),
        "synthetic": list(drawn(options.seed, options.n)),
    }
    print("\n".join(tables(entries)))


if __name__ == "__main__":
    main()
