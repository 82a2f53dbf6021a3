"""What this machine does at best on one thread, measured in the same run as what is held against it.

All on arrays in the nearest cache, but for the bandwidth. The best of some repeats counts: others on the
machine make a loop slower, never faster.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from math import log2

import numpy as np

REPEATS = 9
BLOCK = 2048
"""Numbers of an array that stays in the first cache beside its result."""
LARGE = 2**23
"""Numbers of an array that no cache holds."""
MATRIX = 256
SHORT = 2000


@dataclass(frozen=True)
class Ceilings:
    """Of one thread, a second each.

    Attributes
    ----------
    flops : additions and multiplications, two for a fused one: a product of matrices by BLAS
    roots : square roots and divisions, by NumPy on arrays
    logs : logarithms; other functions like it (exp, atan2, cos) are counted as one
    compares : of a sort of numbers, n log2 n each
    bytes : read and written: a copy
    hashed : bytes of SHA-256
    calls : of a Python function that does nothing
    numpy_calls : of a NumPy function on three numbers
    """

    flops: float
    roots: float
    logs: float
    compares: float
    bytes: float
    hashed: float
    calls: float
    numpy_calls: float

    @classmethod
    def measured(cls) -> "Ceilings":
        """Takes about half a second."""
        rng = np.random.default_rng(0)
        matrix, result = rng.random((MATRIX, MATRIX)), np.empty((MATRIX, MATRIX))
        block, out, three = rng.random(BLOCK) + 0.5, np.empty(BLOCK), rng.random(3)
        large, copied, hashed = np.zeros(LARGE), np.ones(LARGE), bytes(2**20)
        to_sort = rng.random(BLOCK)

        def sort() -> None:
            np.copyto(out, to_sort)
            out.sort()

        return cls(
            flops=2.0 * MATRIX**3 * rate(lambda: np.matmul(matrix, matrix, out=result), 4),
            roots=BLOCK * rate(lambda: np.sqrt(block, out=out), SHORT),
            logs=BLOCK * rate(lambda: np.log(block, out=out), SHORT),
            compares=BLOCK * log2(BLOCK) * rate(sort, SHORT // 10),
            bytes=2.0 * large.nbytes * rate(lambda: np.copyto(copied, large), 1),
            hashed=len(hashed) * rate(lambda: sha256(hashed), 2),
            calls=rate(_nothing, 10 * SHORT),
            numpy_calls=rate(lambda: np.add(three, three), SHORT),
        )


def _nothing() -> None:
    pass


def rate(work: Callable[[], object], times: int) -> float:
    """How often a second it is done at best, counted over so many times in a row."""
    fastest = np.inf
    for _ in range(REPEATS):
        started = time.process_time_ns()
        for _ in range(times):
            work()
        fastest = min(fastest, time.process_time_ns() - started)
    return 1e9 * times / max(fastest, 1)


def calibration() -> float:
    """Seconds of a fixed loop of what fits are made of: Python, small and larger arrays, a sort, a product.

    Figures of another day, or machine, are compared as multiples of it.
    """
    rng = np.random.default_rng(0)
    three, points, square = rng.random(3), rng.random((3000, 3)), rng.random((64, 64))

    def loop() -> None:
        for _ in range(400):
            _nothing()
            np.add(three, three)
        for _ in range(10):
            np.linalg.norm(points, axis=1).sort()
            np.log(points + 1.0)
            np.matmul(square, square)

    return 1.0 / rate(loop, 1)
