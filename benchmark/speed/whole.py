"""primfit with all parts of its answer, as `POST /fit` computes them by default.

`python -m primfit.benchmark.speed.whole`, the child of a race, is `benchmark.child` with these methods beside
the others.
"""

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.recognize import recognize
from primfit.fitting.verdict.classifier import Classifier

from ..child import main
from ..methods import METHODS, Answer
from ..methods.primfit import Primfit, PrimfitReversed


class Whole(Primfit):
    """The kind is not given."""

    name = "primfit-whole"
    settings = "as shipped, and all parts of the answer in plain values"

    def fit(self, points: Array, kind: str | None) -> Answer:
        return whole(points, self.classifier)


class WholeReversed(PrimfitReversed):
    """The same with the worst ranking there is."""

    name = "primfit-whole-reversed"

    def fit(self, points: Array, kind: str | None) -> Answer:
        return whole(points, self.classifier)


def whole(points: Array, classifier: Classifier | None) -> Answer:
    """What was recognised, once all of it has been written out."""
    answer = recognize(points, classifier=classifier)
    answer.to_dict()
    return Answer(answer.status, answer.primitive, attempts=tuple(each.kind for each in answer.attempts))


METHODS.update({each.name: f"{__package__}.whole:{each.__name__}" for each in (Whole, WholeReversed)})

if __name__ == "__main__":
    main()
