"""The answers that are held against the oracles."""

from typing import Any

from primfit.fitting.primitives import parameters
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import Constraints

from .oracles import Array, Surface, long
from .trial import UnfittedError


def fitted(
    kind: str, points: Array, criterion: str, constraints: dict[str, Any] | None = None, refused: bool = False
) -> Surface:
    """What primfit answers for points (N, 3) when it is given the kind.

    The best try of `no_fit` is an answer, too, where `refused` is true; else `UnfittedError` is raised.
    """
    known = Constraints.of(constraints or {})
    answer = recognize(points, Config((kind,), criterion, constraints=known))  # type: ignore[arg-type]
    if answer.primitive is None or (answer.status != "fitted" and not refused):
        raise UnfittedError(f"{answer.status}: {answer.message}")
    return long(parameters(answer.primitive))
