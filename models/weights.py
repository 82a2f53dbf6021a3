"""Shipped weights: plain arrays in an npz file, described by a JSON card that is checked to the letter."""

import hashlib
import io
import json
import zipfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .features import FEATURE_VERSION
from .rough import KINDS

DIRECTORY = Path(__file__).with_name("weights")

ARCHIVE_DATE = (1980, 1, 1, 0, 0, 0)
"""Written into every archive, so that equal arrays make equal bytes."""


class WeightsMismatchError(RuntimeError):
    """The weights are not those that this version of the code can use."""


@dataclass(frozen=True)
class Card:
    """What stands beside the weights.

    `arrays` gives dtype and shape of each array, `recipe` the options and `seed` that rebuild them, `metrics`
    what they reached on clouds they were not built from.
    """

    name: str
    classes: tuple[str, ...]
    feature_version: int
    arrays: dict[str, str]
    recipe: dict[str, Any]
    seed: int
    metrics: dict[str, Any]
    sha256: str


def archive(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """The arrays as the bytes of an npz file; the same arrays give the same bytes."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as file:
        for name in sorted(arrays):
            entry = io.BytesIO()
            np.lib.format.write_array(entry, np.ascontiguousarray(arrays[name]), allow_pickle=False)
            file.writestr(zipfile.ZipInfo(f"{name}.npy", ARCHIVE_DATE), entry.getvalue())
    return buffer.getvalue()


def describe(arrays: Mapping[str, NDArray[Any]]) -> dict[str, str]:
    """dtype and shape of each array, as cards hold them."""
    return {name: f"{arrays[name].dtype.str} {list(arrays[name].shape)}" for name in sorted(arrays)}


def save(
    arrays: Mapping[str, NDArray[Any]],
    name: str,
    recipe: dict[str, Any],
    seed: int,
    metrics: dict[str, Any],
    directory: Path = DIRECTORY,
) -> Card:
    """Write NAME.npz and NAME.json; returns the card."""
    content = archive(arrays)
    card = Card(
        name=name,
        classes=KINDS,
        feature_version=FEATURE_VERSION,
        arrays=describe(arrays),
        recipe=recipe,
        seed=seed,
        metrics=metrics,
        sha256=hashlib.sha256(content).hexdigest(),
    )
    directory.mkdir(parents=True, exist_ok=True)
    (directory / f"{name}.npz").write_bytes(content)
    (directory / f"{name}.json").write_text(json.dumps(asdict(card), indent=2) + "\n", encoding="utf-8")
    return card


def load(name: str, directory: Path = DIRECTORY) -> tuple[dict[str, NDArray[Any]], Card]:
    """The arrays and the card of the weights `name`.

    Raises
    ------
    WeightsMismatchError
        A file is missing or damaged, or the card names other classes, features or bytes than those found.
    """
    try:
        content = (directory / f"{name}.npz").read_bytes()
        card = _read_card(json.loads((directory / f"{name}.json").read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        raise WeightsMismatchError(f"the weights {name} cannot be read: {error}") from error
    _same(name, "name", card.name, name)
    _same(name, "class order", card.classes, KINDS)
    _same(name, "feature version", card.feature_version, FEATURE_VERSION)
    _same(name, "SHA-256", card.sha256, hashlib.sha256(content).hexdigest())
    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        arrays = {entry: file[entry] for entry in file.files}
    _same(name, "arrays", card.arrays, describe(arrays))
    return arrays, card


def _read_card(content: Any) -> Card:
    names = {field.name for field in fields(Card)}
    if not isinstance(content, dict) or set(content) != names:
        raise ValueError(f"a card holds exactly {', '.join(sorted(names))}")
    return Card(**{**content, "classes": tuple(content["classes"])})


def _same(name: str, what: str, on_card: object, found: object) -> None:
    if on_card != found or type(on_card) is not type(found):
        message = f"weights {name}: the card's {what} is {on_card!r}, but {found!r} is needed"
        raise WeightsMismatchError(message)
