"""An ambiguous answer with every field filled, whatever the rule of the verdict is."""

from dataclasses import replace

from primfit.fitting.answer.result import Alternative, Recognition
from primfit.fitting.answer.values import Deviation
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from tests.fitting.clouds import EXAMPLES, Array, noisy

CORRELATED, SMOOTH = Deviation(0.004, 0.35), Deviation(0.4, 60.0)


def cloud_of(kind: str) -> Array:
    return noisy(EXAMPLES[kind], 200, 0.01)


def ambiguous(first: str = "cylinder") -> Recognition:
    """One kind first and the four others as its alternatives, each as it was fitted to a cloud of its own."""
    alone = {kind: recognize(cloud_of(kind), Config(kinds=(kind,))) for kind in EXAMPLES}
    answer = alone.pop(first)
    assert answer.noise
    return replace(
        answer,
        status="ambiguous",
        noise=replace(answer.noise, correlated=CORRELATED, smooth=SMOOTH),
        alternatives=tuple(_alternative(other, -float(i)) for i, other in enumerate(alone.values(), 1)),
        attempts=(
            replace(answer.attempts[0], evidence=0.0),
            *(other.attempts[0] for other in alone.values()),
        ),
    )


def _alternative(found: Recognition, evidence: float) -> Alternative:
    assert found.primitive and found.error
    return Alternative(found.primitive, found.error, found.extents, found.uncertainty, evidence)
