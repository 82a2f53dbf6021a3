"""Which primitive is it? Classifiers that rank the kinds before anything is fitted."""

from functools import cache
from typing import TYPE_CHECKING

from .names import CLASSIFIERS

if TYPE_CHECKING:
    from primfit.fitting.verdict.classifier import Classifier

__all__ = ["CLASSIFIERS", "load_classifier"]


@cache
def load_classifier(name: str) -> "Classifier | None":
    """The classifier of that name, loaded once; None for `none`.

    Raises
    ------
    ValueError : an unknown name
    models.weights.WeightsMismatchError : shipped weights that do not fit this version
    """
    if name == "none":
        return None
    if name == "network":
        from .network import NetworkClassifier

        return NetworkClassifier.shipped()
    if name == "knn":
        from .knn import KnnClassifier

        return KnnClassifier.shipped()
    raise ValueError(f"classifier must be one of {', '.join(CLASSIFIERS)}, not {name!r}")
