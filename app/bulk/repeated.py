"""A value that stands twice among any number of them, in memory that does not grow with it."""

from collections.abc import Callable, Iterable
from hashlib import blake2b

import numpy as np

HELD = 4_000_000
"""Values of which a number of 64 bits each is held at a time."""


def repeated(values: Callable[[], Iterable[str]]) -> str | None:
    """One of the values that stand there several times; None where there is none.

    They are gone through more than once, each time as `values()` gives them.
    """
    n_rounds = -(-sum(1 for _ in values()) // HELD)
    for number in range(n_rounds):
        told = (key for value in values() if (key := _key(value)) % n_rounds == number)
        keys = np.sort(np.fromiter(told, np.uint64))
        if found := _equal(values(), set(keys[1:][keys[1:] == keys[:-1]].tolist())):
            return found
    return None


def _equal(values: Iterable[str], keys: set[int]) -> str | None:
    """A value that stands there twice, of those that have these keys: two values may share one."""
    seen: set[str] = set()
    for value in values if keys else ():
        if _key(value) in keys:
            if value in seen:
                return value
            seen.add(value)
    return None


def _key(value: str) -> int:
    return int.from_bytes(blake2b(value.encode("utf-8", "surrogateescape"), digest_size=8).digest())
