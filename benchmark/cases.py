"""Labelled clouds to measure on: the generator's, and any folder in the layout of the SHREC 2022 track."""

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fitting.geometry import Array
from fitting.primitives import Primitive
from fitting.primitives.shrec22 import from_vector
from synthetic.shrec import batch


@dataclass(frozen=True, eq=False)
class Case:
    """One cloud with its truth; `group` is the perturbation, or empty where it is not known."""

    name: str
    points: Array
    truth: Primitive
    group: str = ""


def synthetic_cases(seed: int, n: int) -> Iterator[Case]:
    """`n` benchmark-like clouds from a seed."""
    for index, cloud in enumerate(batch(seed, n)):
        if cloud.primitive is not None:  # foreign shapes have none
            yield Case(f"{seed}-{index}", cloud.points, cloud.primitive, cloud.perturbation)


def shrec22_cases(folder: Path) -> Iterator[Case]:
    """The clouds `clouds/pointCloud{i}.txt` of a folder with their truth in `ground_truth.csv`."""
    with (folder / "ground_truth.csv").open(newline="") as file:
        for number, label, *parameters in csv.reader(file):
            points = np.loadtxt(folder / "clouds" / f"pointCloud{number}.txt", delimiter=",")
            yield Case(number, points, from_vector(int(label), list(map(float, parameters))))
