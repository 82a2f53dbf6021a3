"""Methods that behave badly, in a process that `benchmark.runner` starts."""

import os
import time

import numpy as np

from primfit.benchmark import child
from primfit.benchmark.methods import METHODS, Answer
from primfit.fitting.primitives.sphere import Sphere

BAD = ("right", "raises", "panics", "crashes", "hangs", "wild", "given", "missing")


class Fake:
    package = "numpy"
    decides_kind = True
    kinds = ("sphere",)
    settings = "none"

    def fit(self, points, kind):
        if len(points) != 10:  # the cloud that warms up
            return Answer("no_fit", None)
        return self.answer(points, kind)

    def answer(self, points, kind):
        return Answer("fitted", Sphere(points.mean(axis=0), 1.0), attempts=("plane", "sphere"))


class Right(Fake):
    name = "right"


class Raises(Fake):
    name = "raises"

    def answer(self, points, kind):
        raise ValueError("these points are no good")


class Panics(Fake):
    name = "panics"

    def answer(self, points, kind):
        raise SystemExit("as some bindings do")


class Crashes(Fake):
    name = "crashes"

    def answer(self, points, kind):
        print("about to abort", flush=True)
        os.abort()


class Hangs(Fake):
    name = "hangs"

    def answer(self, points, kind):
        time.sleep(60.0)


class Wild(Fake):
    name = "wild"

    def answer(self, points, kind):
        return Answer("fitted", Sphere(points.mean(axis=0), np.inf))


class Given(Fake):
    name = "given"
    decides_kind = False

    def answer(self, points, kind):
        points[:] = 0.0  # its own copy
        return Answer("fitted", Sphere([0, 0, 0], 1.0), note=f"was given {kind}")


METHODS.update({name: f"__main__:{name.capitalize()}" for name in BAD if name != "missing"})
METHODS["missing"] = "no_such_package:Method"

if __name__ == "__main__":
    child.versions = lambda method: {"fake": "1"}
    child.main()
