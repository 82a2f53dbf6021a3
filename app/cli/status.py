"""How a command ends, and what it complains of."""

import sys
from collections.abc import Iterable

import typer

# Exit status: of several files the worst decides, in this order.
EXIT = {"fitted": 0, "ambiguous": 3, "no_fit": 4}
BAD_INPUT = 2
INTERNAL_ERROR = 1
INTERRUPTED = 130
BADNESS = (*EXIT.values(), BAD_INPUT, INTERNAL_ERROR)


def complain(subject: str, message: str) -> None:
    """Say what is wrong on standard error; names from files may hold what would move a terminal's cursor."""
    line = f"primfit: {subject}: {message}"
    print("".join(letter if letter.isprintable() else "?" for letter in line), file=sys.stderr)


def refused(subject: str, message: str) -> typer.Exit:
    """Complain, and end the command as one that was given something bad: to be raised."""
    complain(subject, message)
    return typer.Exit(BAD_INPUT)


def worst(statuses: Iterable[int]) -> int:
    """That of several files; 0 of none."""
    return max(statuses, key=BADNESS.index, default=0)
