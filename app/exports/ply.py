"""PLY, binary and little-endian, with coordinates that keep all their digits."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Element:
    """A kind of rows: its properties as PLY declares them, and the rows (N,) as packed records."""

    name: str
    properties: Sequence[str]
    rows: np.ndarray


def ply(comment: str, *elements: Element) -> bytes:
    """The file; the comment is ASCII."""
    header = ["ply", "format binary_little_endian 1.0", f"comment {comment}"]
    for element in elements:
        header.append(f"element {element.name} {len(element.rows)}")
        header += [f"property {declared}" for declared in element.properties]
    content = (element.rows.tobytes() for element in elements)
    return "\n".join((*header, "end_header", "")).encode("ascii") + b"".join(content)
