"""`primfit synth`: clouds of a recipe in the layout of the SHREC 2022 track, with a picture of a sample."""

import csv
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from primfit.fitting.shrec22 import to_vector

from .clouds import SyntheticCloud
from .draw import clouds
from .picture import draw, has_matplotlib, require_matplotlib
from .recipes import RECIPES

PICTURED = 30
ATTRIBUTES = (
    "family",
    "kind",
    "perturbation",
    "exact_share",
    "noise",
    "correlation",
    "outlier_share",
    "arc",
    "step",
    "extent",
)
"""What `attributes.csv` says of each cloud; empty where it is not known."""
SENSOR_ATTRIBUTES = ("sensor", "field_range", "effects")
"""And of a sensor's cloud besides; the effects as `name=size` with semicolons between them."""


class UnknownRecipeError(ValueError):
    """There is no recipe of this name."""

    def __init__(self, name: str) -> None:
        super().__init__(f"there is no recipe {name!r}; there are {', '.join(RECIPES)}")


def write(
    drawn: Iterable[SyntheticCloud], out: Path, columns: tuple[str, ...] = ATTRIBUTES
) -> list[SyntheticCloud]:
    """Write clouds and truth under a folder; returns the first ones, to be pictured.

    `clouds/pointCloud{i}.txt` holds `x,y,z` a line, from i = 1, `ground_truth.csv` a row `i,label,parameters`
    for each cloud that is a primitive, and `attributes.csv` a row of `columns` for each cloud. Numbers are
    written so that they are read back to the last bit.
    """
    (out / "clouds").mkdir(parents=True, exist_ok=True)
    first: list[SyntheticCloud] = []
    with (
        (out / "ground_truth.csv").open("w", newline="") as truth_file,
        (out / "attributes.csv").open("w", newline="") as attributes_file,
    ):
        truths, attributes = (csv.writer(f, lineterminator="\n") for f in (truth_file, attributes_file))
        attributes.writerow(("i", "n_points", *columns))
        for i, cloud in enumerate(drawn, start=1):
            lines = (",".join(map(repr, row)) for row in cloud.points.tolist())
            (out / "clouds" / f"pointCloud{i}.txt").write_text("\n".join(lines) + "\n")
            if cloud.primitive is not None:
                label, numbers = to_vector(cloud.primitive)
                truths.writerow((i, label, *numbers))
            attributes.writerow((i, len(cloud.points), *(_cell(cloud, name) for name in columns)))
            if len(first) < PICTURED:
                first.append(cloud)
    return first


def _cell(cloud: SyntheticCloud, name: str) -> Any:
    value = getattr(cloud, name)
    if isinstance(value, Mapping):
        return "; ".join(f"{effect}={size:.6g}" for effect, size in value.items())
    return "" if value is None else float(value) if isinstance(value, np.floating) else value


def synth(recipe: str, out: Path, n: int = 100, seed: int = 0, picture: bool | None = None) -> str:
    """Write n clouds of a recipe with their truth and, as `sample.png`, a picture of the first thirty.

    Cloud i is the same for any n. With `picture=None` the picture is drawn if matplotlib is installed.
    Returns a line that says what was done. Raises `UnknownRecipeError` and, with `picture=True` only,
    `MissingMatplotlibError` before anything is written.
    """
    if recipe not in RECIPES:
        raise UnknownRecipeError(recipe)
    if picture:
        require_matplotlib()
    columns = (*ATTRIBUTES, *SENSOR_ATTRIBUTES) if recipe == "sensor" else ATTRIBUTES
    first = write(clouds(replace(RECIPES[recipe], seed=seed), n), out, columns)
    done = f"{n} clouds of the recipe {recipe}, seed {seed}, in {out}"
    if picture or (picture is None and has_matplotlib()):
        draw(first, out / "sample.png")
    elif picture is None:
        done += "; no picture, which needs matplotlib: pip install 'matplotlib>=3.8'"
    return done
