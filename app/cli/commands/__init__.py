"""`primfit` on the command line. What a command needs is imported when it runs: `primfit --help` is quick."""

import os
import sys
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from ..alphabet import write_in_any_alphabet
from ..ending import ended_plainly
from .batch import batch
from .fit import fit
from .jobs import jobs
from .mcp import mcp
from .parts import bench, paper, synth
from .service import openapi, serve, settings
from .table import table

# As in the service: one thread a process, so that every way in gives the same numbers.
for _threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")


class Commands(TyperGroup):
    """All of them end alike."""

    def make_context(self, *args: Any, **kwargs: Any) -> Any:
        with ended_plainly():
            return super().make_context(*args, **kwargs)

    def invoke(self, ctx: Any) -> Any:
        with ended_plainly(ctx):
            return super().invoke(ctx)


app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    # Frames and colors are for terminals: in a pipe they are blanks at the end of each line.
    rich_markup_mode="rich" if sys.stdout is not None and sys.stdout.isatty() else None,
    help="Which geometric primitive is this 3D point cloud, and with which parameters?",
)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"primfit {version('primfit')}")
        raise typer.Exit


@app.callback()
def _primfit(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None: ...


for _command in (fit, batch, table, serve, mcp, settings, openapi, synth, paper):
    app.command()(_command)
app.add_typer(jobs, name="jobs")
# It has a help of its own.
app.command(
    context_settings={"allow_extra_args": True, "ignore_unknown_options": True}, add_help_option=False
)(bench)


def main() -> None:
    """Entry point of the `primfit` command, which has this name as `python -m primfit`, too."""
    write_in_any_alphabet()
    app(prog_name="primfit")


if __name__ == "__main__":
    main()
