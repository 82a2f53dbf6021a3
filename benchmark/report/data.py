"""The records as the report looks at them."""

from collections.abc import Container, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..cases import CASE_SETS, Description, Level
from ..methods import METHODS, PAPER, PEERS, PUBLISHED
from ..real import DESCRIPTION as REAL_DESCRIPTION
from ..real import REAL
from ..records import Record, RecordsFile
from ..scores import grouped
from ..track import DESCRIPTION, TRACK

OURS = "primfit"

FOLDERS = {REAL: ("--real DIR", REAL_DESCRIPTION), TRACK: ("--shrec22 DIR", DESCRIPTION)}
"""The sets that folders make: how a run is told of them, and what they are."""


class NoRecordsError(ValueError):
    """There is nothing to report, or records that cannot stand beside each other."""


@dataclass(frozen=True)
class Data:
    """Records with what is known of their methods and sets.

    Attributes
    ----------
    records : all of them
    about : what `methods.json` says of each method
    """

    records: Sequence[Record]
    about: dict[str, dict[str, Any]]

    @classmethod
    def of(cls, file: RecordsFile) -> "Data":
        """Raises `NoRecordsError` for a folder without records, or with records of one cloud that differs."""
        records = list(file.read())
        if not records:
            raise NoRecordsError(f"{file.path} holds no records: run `primfit bench run` first")
        for (set_, seed, case), mine in grouped(records, lambda record: record.key[:3]).items():
            if len({record.cloud for record in mine}) > 1:
                raise NoRecordsError(
                    f"{file.path}: the methods saw different clouds as {set_} {case} of seed {seed}; "
                    f"make the records anew with --restart"
                )
        return cls(records, file.methods())

    def only(self, methods: Container[str]) -> "Data":
        """The records of these methods."""
        return replace(self, records=[record for record in self.records if record.method in methods])

    @property
    def methods(self) -> list[str]:
        """In the order of the registry, published answers last."""
        seen = {record.method for record in self.records}
        return [name for name in (*METHODS, *PUBLISHED) if name in seen]

    @property
    def sets(self) -> list[str]:
        """In the order of the registry, those of folders first."""
        seen = {record.set for record in self.records}
        return [name for name in (*FOLDERS, *CASE_SETS) if name in seen]

    def decides(self, method: str) -> bool:
        return bool(self.about[method]["decides_kind"])

    def deciders(self) -> list[str]:
        return [method for method in self.methods if self.decides(method)]

    def of_set(self, set_: str, method: str | None = None) -> list[Record]:
        return [r for r in self.records if r.set == set_ and method in (None, r.method)]

    def at_level(self, set_: str, group: str, level: Level) -> list[Record]:
        return [record for record in self.of_set(set_) if record.groups.get(group) == level]

    def of_method(self, method: str) -> list[Record]:
        return [record for record in self.records if record.method == method]

    def by_method(self, records: Iterable[Record]) -> dict[str, list[Record]]:
        """Records by method, in the order of the registry."""
        found = grouped(records, lambda record: record.method)
        return {method: found[method] for method in self.methods if method in found}

    def levels(self, set_: str, group: str) -> list[Level]:
        """The levels of a group that occur, in order."""
        seen = {record.groups.get(group) for record in self.of_set(set_)}
        return [level for level in (*described(set_).groups[group], "unknown") if level in seen]

    def groups(self, set_: str) -> list[str]:
        """The groups of a set whose levels are known for some record."""
        return [group for group in described(set_).groups if self.levels(set_, group)]

    def commands(self, sets: Iterable[str]) -> list[str]:
        """What reproduces the records of sets."""
        return [
            self._command(set_, seed, mine)
            for (set_, seed), mine in grouped(self.records, lambda r: (r.set, r.seed)).items()
            if set_ in sets
        ]

    def _command(self, set_: str, seed: int, records: Sequence[Record]) -> str:
        methods = [method for method in METHODS if method in {record.method for record in records}]
        count = len({record.case for record in records})
        chosen = FOLDERS[set_][0] if set_ in FOLDERS else f"--set {set_} --n {count} --seed {seed}"
        ours = [f"--method {method}" for method in methods if method not in PEERS]
        alone = ours == [f"--method {OURS}"]
        peers = ["--peers"] if any(method in PEERS for method in methods) else []
        return " ".join(["primfit bench run", chosen, *([] if alone else ours), *peers])


def of_the_paper(methods: Iterable[str]) -> list[str]:
    """Those of the benchmark's paper: made again, or as their authors published their answers."""
    return [method for method in methods if method in (*PAPER, *PUBLISHED)]


def described(set_: str) -> Description:
    return FOLDERS[set_][1] if set_ in FOLDERS else CASE_SETS[set_].description


def common(one: Sequence[Record], other: Sequence[Record]) -> tuple[list[Record], list[Record]]:
    """The records of two methods on the clouds that both were asked about, in the same order."""
    mine = {record.key[:3]: record for record in one}
    shared = [record for record in other if record.key[:3] in mine]
    return [mine[record.key[:3]] for record in shared], shared


def median_seconds(records: Iterable[Record]) -> float:
    """NaN where no time is known."""
    values = [record.seconds for record in records if record.seconds is not None]
    return float(np.median(values)) if values else np.nan
