"""Which clouds a batch is about, and where the answer for each of them goes."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ..readers.formats import PACKED, SUFFIXES
from .identity import identity

ENDINGS = {"json": ".json", "shrec22": "_prediction.txt"}


class CollisionError(ValueError):
    """Two inputs would write the same output, or an output would overwrite an input."""


@dataclass(frozen=True)
class Plan:
    """What a batch does.

    Attributes
    ----------
    targets : output -> input, in a fixed order
    searched : inputs that were found in a folder, not named, and their places in it
    others : how many files of other suffixes lie in the folders, by suffix
    """

    targets: dict[Path, str]
    searched: dict[str, Path]
    others: Counter[str]


def plan(inputs: Sequence[str], out: Path, format: str, labels: str | None = None) -> Plan:
    """Where the answers go; a folder is searched and its inner folders are kept in `out`.

    With `labels` the answers for the segments of an input go into a folder: its output without the ending.

    Raises
    ------
    CollisionError
        If two inputs differ only in their suffix or folder, or in a link on the way to their outputs, so that
        one answer would overwrite the other.
    """
    targets: dict[Path, str] = {}
    places: dict[Path, str] = {}
    real = cache(Path.resolve)
    found, searched, others = _expand(inputs)
    for name, inner in found:
        target = out / inner.with_name(_unpacked(inner).stem + ENDINGS[format])
        place = real(target.parent) / target.name
        if place not in places:
            places[place] = targets[target] = name
        elif Path(places[place]).resolve() != Path(name).resolve():
            raise CollisionError(f"{places[place]} and {name} would both write {target}")
    sources = {identity(name) for name in targets.values()} - {None}
    for target, name in targets.items():
        if identity(target) in sources:
            raise CollisionError(f"the answer for {name} would overwrite the input {target}")
    if labels:
        _check_folders({folder_of(target, format): name for target, name in targets.items()})
    return Plan(targets, searched, others)


def folder_of(target: Path, format: str) -> Path:
    """Where the answers for the segments of an input go, if its own answer would be `target`."""
    return target.with_name(target.name.removesuffix(ENDINGS[format]))


def _check_folders(folders: Mapping[Path, str]) -> None:
    """No two inputs write into one folder, and none into a folder that an input lies in."""
    resolved: dict[Path, str] = {}
    for folder, name in folders.items():
        other = resolved.setdefault(folder.resolve(), name)
        if other != name:
            raise CollisionError(f"{other} and {name} would both write into {folder}")
    for folder, name in resolved.items():
        for outer in resolved.keys() & set(folder.parents):
            raise CollisionError(f"{resolved[outer]} and {name} would both write into {outer}")
        for inner in resolved.keys() & set(Path(name).resolve().parents):
            raise CollisionError(f"the answers for {resolved[inner]} would lie beside the input {name}")


def _expand(inputs: Sequence[str]) -> tuple[list[tuple[str, Path]], dict[str, Path], Counter[str]]:
    """Files as (name, path inside the output folder), those of them that were found in folders, and what else
    is there, by suffix."""
    found: list[tuple[str, Path]] = []
    others: Counter[str] = Counter()
    named = {name for name in inputs if not Path(name).is_dir()}
    for name in inputs:
        path = Path(name)
        if name in named:
            found.append((name, Path(path.name)))
            continue
        for file in sorted(path.rglob("*")):
            if not file.is_file() or file.name.endswith(ENDINGS["shrec22"]):
                continue
            if _unpacked(file).suffix.lower() in SUFFIXES:
                found.append((str(file), file.relative_to(path)))
            else:
                others[file.suffix.lower() or "without suffix"] += 1
    return found, {name: inner for name, inner in found if name not in named}, others


def _unpacked(file: Path) -> Path:
    """`cloud.csv` for `cloud.csv.gz`."""
    return file.with_suffix("") if file.suffix.lower() in PACKED else file
