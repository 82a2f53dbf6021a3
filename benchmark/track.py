"""Folders in the layout of the SHREC 2022 track: the public dataset, parts of it, output of `primfit synth`.

Clouds are files `pointCloud{i}.txt` with `x,y,z` a line, anywhere in the folder. Their truth stands in one
file `ground_truth.csv` with a line `i,label,parameters`, or in a file `GTpointCloud{i}.txt` each with one
number a line. `perturbation.csv`, where it is there, has a line `i` and the track's 13 numbers. What the
authors of a method of the paper answered may stand beside, `m4_predictions.csv` with `i,label,parameters`.
"""

import csv
import re
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.shrec22 import from_vector, to_vector
from primfit.synthetic.perturb import TYPES, Perturbation

from .cases import CASE_SETS, Case, Description, track_groups
from .methods import PAPER, PUBLISHED

TRACK = "shrec22"
"""The name of the set that a folder makes."""

DESCRIPTION = Description(
    "Clouds of SHREC 2022",
    "Clouds of the track with their truth, as its authors published them.",
    CASE_SETS["shrec"].description.groups,
)

FLAGS = {"uniform": 0, "gaussian": 3, "undersampling": 6, "missing_part": 8, "bump": 10}
"""Where the flags stand in the 13 numbers of `perturbation.csv`."""


class TrackError(ValueError):
    """A folder without clouds or truth, with two clouds of one number, or with a file that cannot be read."""


class TrackFolder:
    """The clouds of a folder that have a truth, in the order of their numbers; read when they are asked for.

    Attributes
    ----------
    published : what methods of the paper answered, by a name of `PUBLISHED` and the number of the cloud

    Raises
    ------
    TrackError : the folder is not in the track's layout
    """

    def __init__(self, folder: Path) -> None:
        self.clouds = _numbered(folder, r"pointCloud(\d+)\.txt")
        if not self.clouds:
            raise TrackError(f"{folder} holds no pointCloud1.txt, pointCloud2.txt, ...")
        self.truths = _truths(folder)
        self.names = [name for name in self.clouds if name in self.truths]
        if not self.names:
            raise TrackError(
                f"{folder} holds {len(self.clouds)} clouds, but no ground_truth.csv or GTpointCloud*.txt for "
                "them"
            )
        self.perturbations = _perturbations(folder)
        self.published = {
            name: found
            for method, name in zip(PAPER, PUBLISHED, strict=True)
            if (found := _published(folder, method))
        }

    @property
    def fingerprint(self) -> int:
        """Another number for a folder with other truths."""
        truths = [(name, to_vector(self.truths[name])) for name in self.names]
        return zlib.crc32(repr(truths).encode())

    def case(self, name: str) -> Case:
        """Raises `TrackError` for a file that holds no points."""
        perturbation = self.perturbations.get(name, "A0" if self.perturbations else "unknown")
        points = read_points(self.clouds[name])
        return Case(name, points, self.truths[name], track_groups(perturbation, len(points)))


def shrec22_cases(folder: Path) -> Iterator[Case]:
    """All cases of a folder."""
    track = TrackFolder(folder)
    return (track.case(name) for name in track.names)


def read_points(path: Path) -> np.ndarray:
    """(N, 3) from `x,y,z` or `x y z` a line."""
    numbers = np.array(re.split(r"[,;\s]+", path.read_text().strip()))
    try:
        return numbers.astype(np.float64).reshape(-1, 3)
    except ValueError as error:
        raise TrackError(f"{path} does not hold three numbers a line: {error}") from None


def _numbered(folder: Path, pattern: str) -> dict[str, Path]:
    """Files whose whole name matches, by the number in it, in its order."""
    found: dict[str, Path] = {}
    for path in sorted(folder.rglob("*.txt")):
        match = re.fullmatch(pattern, path.name)
        if match and found.setdefault(match[1], path) != path:
            raise TrackError(
                f"{found[match[1]]} and {path} have the same number: name a folder with one of them"
            )
    return dict(sorted(found.items(), key=lambda item: int(item[0])))


def _truths(folder: Path) -> Mapping[str, Primitive]:
    vectors = {
        number: path.read_text().split()
        for number, path in _numbered(folder, r"(?i:GT)_?pointCloud(\d+)\.txt").items()
    }
    vectors |= _lines(folder, "ground_truth.csv")
    return {number: _primitive("truth of", number, vector) for number, vector in vectors.items()}


def _published(folder: Path, method: str) -> Mapping[str, Primitive]:
    vectors = _lines(folder, f"{method}_predictions.csv")
    return {
        number: _primitive(f"answer of {method} on", number, vector) for number, vector in vectors.items()
    }


def _lines(folder: Path, name: str) -> dict[str, list[str]]:
    """What stands behind the number of a cloud, by it, in all files of this name."""
    found: dict[str, list[str]] = {}
    for path in folder.rglob(name):
        with path.open(newline="") as file:
            found |= {row[0]: row[1:] for row in csv.reader(file) if row}
    return found


def _primitive(what: str, number: str, vector: list[str]) -> Primitive:
    try:
        return from_vector(int(vector[0]), list(map(float, vector[1:])))
    except (ValueError, IndexError) as error:
        raise TrackError(f"the {what} cloud {number} cannot be read: {error}") from None


def _perturbations(folder: Path) -> Mapping[str, str]:
    """The types A0 to A9; a clean cloud may have no line."""
    types = {perturbation: name for name, perturbation in TYPES.items()}
    found: dict[str, str] = {}
    for path in folder.rglob("perturbation.csv"):
        with path.open(newline="") as file:
            for number, *values in csv.reader(file):
                done = {name for name, place in FLAGS.items() if float(values[place])}
                found[number] = types.get(_perturbation(done), "unknown")
    return found


def _perturbation(done: set[str]) -> Perturbation:
    noise = next((name for name in ("uniform", "gaussian") if name in done), None)
    removal = next((name for name in ("undersampling", "missing_part") if name in done), None)
    return Perturbation(noise, "bump" in done, removal)
