"""The six methods of the benchmark's paper, made again in `primfit.paper`."""

from primfit.fitting.geometry.vectors import Array
from primfit.models.weights import WeightsMismatchError
from primfit.paper.method import load
from primfit.synthetic.recipes import KINDS

from . import Answer


class Paper:
    """One of them, by its name."""

    name: str
    package = "primfit"
    decides_kind = True
    kinds = KINDS

    def __init__(self) -> None:
        try:
            self.method = load(self.name)
        except WeightsMismatchError as error:
            raise ImportError(str(error)) from None
        self.settings = self.method.settings

    def fit(self, points: Array, kind: str | None) -> Answer:
        found = self.method.fit(points)
        if found.primitive is None:
            return Answer("no_fit", None, found.note, found.attempts)
        return Answer("fitted", found.primitive, found.note, found.attempts)


class M1(Paper):
    name = "m1"


class M2(Paper):
    name = "m2"


class M3(Paper):
    name = "m3"


class M4(Paper):
    name = "m4"


class M5(Paper):
    name = "m5"


class M6(Paper):
    name = "m6"
