"""The names of the classifiers, spelt once. Nothing slow is imported here: the command line asks, too."""

from typing import Literal, get_args

ClassifierName = Literal["network", "knn", "none"]
CLASSIFIERS: tuple[str, ...] = get_args(ClassifierName)
"""The names that `load_classifier` knows; `none` stands for trying every kind."""

CLASSIFIER: ClassifierName = "network"
"""The default."""
