"""How a command ends that is cut short: by Ctrl-C, or because nobody reads on."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import typer

from .status import INTERRUPTED, complain


@contextmanager
def ended_plainly(context: typer.Context | None = None) -> Iterator[None]:
    """For what commands do: Ctrl-C is one line on standard error, and a reader that leaves is no fault.

    `primfit fit --json FILES | head -1` is what such a reader is for: it has what it wanted, and the exit
    status is 0.
    """
    try:
        try:
            yield
        finally:
            if sys.stdout is not None:
                sys.stdout.flush()
    except BrokenPipeError:
        _write_nowhere()
        raise typer.Exit(0) from None
    except KeyboardInterrupt:
        complain((context and context.invoked_subcommand) or "primfit", "interrupted")
        raise typer.Exit(INTERRUPTED) from None


def _write_nowhere() -> None:
    """What is still held for standard output is thrown away: else Python complains of it when it ends."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
