"""One answer of many, and its picture."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from primfit.fitting.answer.result import Recognition

from ...engine.names import Ids
from ..fitted import Fitted, NothingToExportError, fitted_points
from ..report import scene_svg

PICTURED = 60
"""Pictures of a report at most: more of them make a page slow."""

DOTS = 500
"""Points of such a picture."""


@dataclass(frozen=True, eq=False)
class Part:
    """An answer of many.

    Attributes
    ----------
    where : what the cloud is called, by column of the table: a label, a file, or both
    name : the same in one text
    recognition : None where the cloud could not be fitted
    problem : why it could not; empty otherwise
    picture : SVG of its points and its primitive; empty where it has none
    """

    where: Mapping[str, Any]
    name: str
    recognition: Recognition | None
    problem: str = ""
    picture: str = ""

    @property
    def status(self) -> str:
        """That of the answer, or `problem`."""
        return "problem" if self.recognition is None else self.recognition.status

    @property
    def message(self) -> str:
        """What the answer says, or the problem."""
        return self.problem if self.recognition is None else self.recognition.message


def pictured(part: Part) -> Part:
    """With its picture, if the answer still has its points, of some of them."""
    if part.recognition is None or part.recognition.points is None:
        return part
    fitted = fitted_points(part.recognition)
    n_points = len(fitted.points)
    if n_points > DOTS:
        rows = np.sort(np.random.default_rng(0).permutation(n_points)[:DOTS])
        fitted = fitted_points(part.recognition.with_points(fitted.points[rows]))
    return replace(part, picture=scene_svg(fitted, fitted.recognition.unit))


def trimmed(parts: Sequence[Part]) -> Iterator[tuple[str, Fitted]]:
    """The accepted primitives that can be trimmed, by names of which no two are the same.

    Raises `NothingToExportError` where there is none, at the end.
    """
    ids, n_found = Ids(), 0
    for part in parts:
        found = part.recognition
        if found is None or found.status == "no_fit" or found.extents is None:
            continue
        n_found += 1
        fitted = Fitted(found)
        said = fitted.primitive.kind + ("" if found.status == "fitted" else f" ({found.status})")
        yield ids.unique(f"{part.name} {said}"), fitted
    if not n_found:
        raise NothingToExportError("no answer has a primitive that can be trimmed")
