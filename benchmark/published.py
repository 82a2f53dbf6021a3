"""Answers that authors published beside clouds, as records like those of methods that run here."""

import zlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.shrec22 import to_vector
from primfit.synthetic.recipes import KINDS

from .records import Outcome, Record, RecordsFile, Scored
from .runner import Work

Answers = Mapping[str, Primitive]
"""By the name of the case."""


def introductions(works: Sequence[Work]) -> dict[str, dict[str, Any]]:
    """What `runner.introduce` says of methods, of those whose answers are published; no machine is known."""
    return {name: _introduction(answers) for work in works for name, answers in work.published.items()}


def _introduction(answers: Answers) -> dict[str, Any]:
    vectors = [(name, to_vector(primitive)) for name, primitive in answers.items()]
    return {
        "package": "answers",
        "decides_kind": True,
        "kinds": list(KINDS),
        "settings": "not run here: what its authors published beside the clouds",
        "versions": {"answers": f"{zlib.crc32(repr(vectors).encode()):08x}"},
    }


def publish(file: RecordsFile, works: Sequence[Work], done: Sequence[Record]) -> Iterator[Record]:
    """Add a record for each published answer that has none yet; how long it took is not known."""
    known = {record.key for record in done}
    for work in works:
        for name in work.names:
            told = {method: answers[name] for method, answers in work.published.items() if name in answers}
            missing = [method for method in told if (work.set, work.seed, name, method) not in known]
            if missing:
                scored = Scored(work.set, work.seed, work.draw(name))
                yield from (_published(file, scored, method, told[method], work) for method in missing)


def _published(file: RecordsFile, scored: Scored, method: str, answer: Primitive, work: Work) -> Record:
    versions = _introduction(work.published[method])["versions"]
    record = scored.record(method, Outcome("fitted", parameters(answer)), versions)
    file.append(record)
    return record
