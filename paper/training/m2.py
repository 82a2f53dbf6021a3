"""Build the references of M2 from synthetic clouds:  python -m primfit.paper.training.m2

The same seed and number give the same bytes, for however many processes. They take minutes and no torch.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from primfit.models.rough import KINDS
from primfit.models.weights import Card, WeightsMismatchError, load, save
from primfit.synthetic import BenchmarkRecipe, cloud

from ..method import DIRECTORY
from ..parts.frames import unit_cube
from ..parts.local_histograms import Local

SEED = 20220
CLOUDS = 6_000
FLAT_SHARE = 0.99
"""Of the reference planes, which are as flat as a plane must be."""
CHUNK = 50

Row = tuple[int, NDArray[np.uint8], NDArray[np.uint8], float]


def row(seed: int, index: int) -> Row:
    """Label, histograms of normals and of surflets, and flatness of a cloud of the benchmark's recipe."""
    made = cloud(BenchmarkRecipe(seed), index)
    with np.errstate(all="ignore"):
        local = Local.of(unit_cube(made.points).normalize(made.points))
    return KINDS.index(made.kind), local.normals, local.surflets, local.flatness


def rows(seed: int, clouds: int, processes: int) -> Iterator[Row]:
    """Those of the first clouds of a seed, in order; how many are done is told on one line."""
    with ProcessPoolExecutor(processes) as pool:
        made = pool.map(partial(row, seed), range(clouds), chunksize=CHUNK)
        for done, each in enumerate(made, 1):
            if done % CHUNK == 0 or done == clouds:
                end = "\r" if done < clouds else "\n"
                print(f"m2: {done} of {clouds} clouds", end=end, file=sys.stderr, flush=True)
            yield each


def references(found: list[Row]) -> dict[str, NDArray[Any]]:
    """The arrays of the weights: surflets are kept of spheres and tori alone."""
    labels, normals, surflets, flatness = (np.array(each) for each in zip(*found, strict=True))
    paired = np.isin(labels, [KINDS.index("sphere"), KINDS.index("torus")])
    return {
        "labels": labels.astype(np.uint8),
        "normals": normals,
        "surflets": surflets[paired],
        "flatness": np.quantile(flatness[labels == KINDS.index("plane")], [FLAT_SHARE]),
    }


def build(seed: int, clouds: int, directory: Path, processes: int = 1) -> Card:
    """Write the weights and their card; those that are there already, made so, stay."""
    command = f"python -m primfit.paper.training.m2 --seed {seed} --clouds {clouds}"
    recipe = {"command": command, "clouds": clouds, "flat_share": FLAT_SHARE}
    try:
        _, card = load("m2", directory)
    except WeightsMismatchError:
        card = None
    if card and (card.seed, card.recipe) == (seed, recipe):
        return card
    return save(references(list(rows(seed, clouds, processes))), "m2", recipe, seed, {}, directory)


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--clouds", type=int, default=CLOUDS)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--out", type=Path, default=DIRECTORY)
    given = parser.parse_args(arguments)
    start = time.perf_counter()
    card = build(given.seed, given.clouds, given.out, given.processes)
    print(f"{given.out / 'm2.npz'}: sha256 {card.sha256}")
    print(f"{time.perf_counter() - start:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
