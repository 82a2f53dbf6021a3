"""primfit with each of its classifiers, and with the worst ranking there is."""

from collections.abc import Mapping

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.recognize import recognize
from primfit.fitting.verdict.classifier import Classifier
from primfit.models import load_classifier
from primfit.synthetic.recipes import KINDS

from . import Answer


class Primfit:
    """primfit as it is shipped."""

    name = "primfit"
    package = "primfit"
    decides_kind = True
    kinds = KINDS
    settings = (
        "as shipped: the network ranks the kinds, robust criterion, no setting that depends on the cloud"
    )

    def __init__(self) -> None:
        self.classifier = self.make_classifier()

    def make_classifier(self) -> Classifier | None:
        return load_classifier("network")

    def fit(self, points: Array, kind: str | None) -> Answer:
        answer = recognize(points, classifier=self.classifier)
        kinds = tuple(attempt.kind for attempt in answer.attempts)
        alternatives = tuple(other.primitive.kind for other in answer.alternatives)
        return Answer(answer.status, answer.primitive, answer.message, kinds, alternatives)


class PrimfitKnn(Primfit):
    name = "primfit-knn"
    settings = "the nearest neighbours rank the kinds; otherwise as shipped"

    def make_classifier(self) -> Classifier | None:
        return load_classifier("knn")


class PrimfitNone(Primfit):
    name = "primfit-none"
    settings = "no classifier: all kinds are tried; otherwise as shipped"

    def make_classifier(self) -> Classifier | None:
        return None


class Reversed:
    """The order of a classifier turned round, with the same probabilities for any cloud.

    Where the classifier is right the true kind comes last.
    """

    def __init__(self, classifier: Classifier) -> None:
        self.classifier = classifier

    def rank(self, points: Array, normals: Array) -> Mapping[str, float]:
        ranked = self.classifier.rank(points, normals)
        worst_first = sorted(KINDS, key=lambda kind: ranked[kind])
        return {kind: 2.0 ** (4 - place) / 31.0 for place, kind in enumerate(worst_first)}


class PrimfitReversed(Primfit):
    name = "primfit-reversed"
    settings = "the network's ranking turned round, to see what a wrong ranking costs; otherwise as shipped"

    def make_classifier(self) -> Classifier | None:
        network = load_classifier("network")
        assert network is not None
        return Reversed(network)
