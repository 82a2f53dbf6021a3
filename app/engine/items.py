"""What is answered of many: a file, or a segment of it, each on a line of its own."""

from dataclasses import dataclass, replace
from typing import Literal, Self

import orjson

from .cut import Label
from .names import Ids


@dataclass(frozen=True)
class Told:
    """What a line of a batch is about: item `index` (from 0) of the `of` items of a file, the first being 1.

    `outcome` is the status of the answer, or `problems`; `label` that of the segment.
    """

    file: int
    index: int
    of: int
    outcome: str
    label: Label | None


@dataclass(frozen=True)
class Item:
    """A file (`label` is None) or one of its segments, by an id that no other item has.

    `file` is the last component of the file's name, made fit to be shown; None where it has no name.
    """

    id: str
    file: str | None
    label: Label | None

    @classmethod
    def of_file(cls, file: str | None, number: int, ids: Ids) -> Self:
        """The file of this name, or of this number where it has none."""
        return cls(ids.of_file(file, number), file, None)

    def segment(self, label: Label, ids: Ids) -> Self:
        """A segment of this file."""
        return replace(self, id=ids.of_segment(self.id, label), label=label)

    def line(self, name: Literal["answer", "problem"], content: bytes) -> bytes:
        """The line for it; what was found, or the problem, stands in it byte for byte."""
        head = orjson.dumps({"id": self.id, "file": self.file, "label": self.label})
        return b'%s,"%s":%s}\n' % (head[:-1], name.encode(), content)
