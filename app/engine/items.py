"""What is answered of many: a file, or a segment of it, each on a line of its own."""

from dataclasses import dataclass
from typing import Literal

import orjson

from .segments import Label


@dataclass(frozen=True)
class Item:
    """A file (`label` is None) or one of its segments, by an id that no other item has.

    `file` is the last component of the file's name, made fit to be shown; None where it has no name.
    """

    id: str
    file: str | None
    label: Label | None

    def line(self, name: Literal["answer", "problem"], content: bytes) -> bytes:
        """The line for it; what was found, or the problem, stands in it byte for byte."""
        head = orjson.dumps({"id": self.id, "file": self.file, "label": self.label})
        return b'%s,"%s":%s}\n' % (head[:-1], name.encode(), content)
