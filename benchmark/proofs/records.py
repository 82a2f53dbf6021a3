"""`proofs.jsonl`: one JSON line for each case, appended as they come, read back by the report."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import numpy as np

from ..sources import digest, own_files
from . import PROOFS
from .trial import Level, UnfittedError

Key = tuple[str, int, int]


@dataclass(frozen=True)
class ProofRecord:
    """One case and what was measured of it.

    Attributes
    ----------
    set, seed, case : what identifies it: `benchmark.proofs.PROOFS[set].draw(seed, case)` is the same case
    groups, drawn : of `benchmark.proofs.trial.Trial`
    figures : by name; None where one is not finite: an answer is missing or another one than it should be
    note : why there are no figures, or empty
    source : start of a SHA-256 of primfit's own files and the proofs'
    """

    set: str
    seed: int
    case: int
    groups: Mapping[str, Level]
    drawn: str
    figures: Mapping[str, float | None]
    note: str
    source: str

    @property
    def key(self) -> Key:
        return self.set, self.seed, self.case


def prove(key: Key) -> ProofRecord:
    """Draw a case and measure it; a case that fails is a record that says so."""
    set_, seed, case = key
    trial = PROOFS[set_].draw(seed, case)
    figures: dict[str, float | None] = {}
    note = ""
    try:
        for name, value in trial.measure().items():
            figures[name] = float(value) if np.isfinite(value) else None
    except UnfittedError as error:
        note = str(error)
    except Exception as error:
        note = f"{type(error).__name__}: {error}"
    return ProofRecord(set_, seed, case, trial.groups, trial.drawn, figures, note, source())


def prove_all(keys: Sequence[Key], processes: int) -> Iterator[ProofRecord]:
    """In the order of the keys."""
    if processes == 1:
        yield from map(prove, keys)
        return
    with ProcessPoolExecutor(processes) as pool:
        try:
            yield from pool.map(prove, keys)
        finally:
            pool.shutdown(cancel_futures=True)


@cache
def source() -> str:
    return digest([*own_files(), *sorted(Path(__file__).parent.glob("*.py"))])


class ProofsFile:
    """The records of a folder; made where it is missing, continued where a run was cut off."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "proofs.jsonl"

    def read(self) -> list[ProofRecord]:
        """The records; a last line that was cut off is left out."""
        if not self.path.exists():
            return []
        lines = self.path.read_text(encoding="utf-8").splitlines(keepends=True)
        return [ProofRecord(**json.loads(line)) for line in lines if line.endswith("\n")]

    def begin(self, asked: Iterable[Key], restart: bool) -> list[Key]:
        """What remains to be done; of a set, records of another state of the code or seed are dropped."""
        wanted = list(asked)
        seeds = {set_: seed for set_, seed, _ in wanted}
        kept = [each for each in self.read() if not restart or each.set not in seeds]
        kept = [each for each in kept if each.set not in seeds or _is_same(each, seeds[each.set])]
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text("".join(map(_line, kept)), encoding="utf-8")
        done = {each.key for each in kept}
        return [key for key in wanted if key not in done]

    def append(self, records: Iterable[ProofRecord]) -> Iterator[ProofRecord]:
        """Write records as they come, and hand them on."""
        with self.path.open("a", encoding="utf-8") as file:
            for record in records:
                file.write(_line(record))
                file.flush()
                yield record


def _is_same(record: ProofRecord, seed: int) -> bool:
    return record.seed == seed and record.source == source()


def _line(record: ProofRecord) -> str:
    return json.dumps(asdict(record), allow_nan=False) + "\n"
