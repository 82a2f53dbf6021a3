"""Commands of parts that `app` does not import: `primfit synth`, `primfit paper` and `primfit bench`."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from .. import options as of
from ..status import BAD_INPUT, complain

NOT_IN_WHEEL = "the wheel leaves these methods out: they want a checkout, by 'pip install --editable .'"


def synth(
    recipe: Annotated[
        Literal["benchmark", "scanner", "scanner-hard", "scanner-large", "sensor", "foreign"],
        typer.Argument(help="The family of clouds.", metavar="RECIPE"),
    ],
    out: Annotated[Path, typer.Option(help="Folder for clouds, truth and picture.", file_okay=False)],
    n: Annotated[int, typer.Option("--n", min=1, help="Number of clouds.")] = 100,
    seed: Annotated[int, typer.Option(min=0, help="Another seed gives other clouds.")] = 0,
    picture: Annotated[
        bool | None,
        typer.Option(help="Draw the first thirty clouds as sample.png; the default with matplotlib."),
    ] = None,
) -> None:
    """Write labeled synthetic clouds.

    Their layout is that of the SHREC 2022 track. Cloud i depends on RECIPE, the seed and i only.
    """
    try:
        print(_installed("synth")(recipe, out, n, seed, picture))
    except (ImportError, OSError) as error:
        complain("synth", str(error))
        raise typer.Exit(BAD_INPUT) from None


def paper(
    context: typer.Context,
    method: Annotated[
        Literal["m1", "m2", "m3", "m4", "m5", "m6"],
        typer.Argument(help="As the paper numbers them.", metavar="METHOD"),
    ],
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE...", help="Clouds of any format, also packed; '-' is standard input."),
    ],
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON, a line for each answer, as that of POST /fit.")
    ] = False,
    columns: of.Columns = None,
    missing: of.Missing = None,
    unit: of.Unit = None,
) -> None:
    """Ask a method of the SHREC 2022 paper about the cloud in each FILE, for comparison.

    They were made again from the paper's text, and need a checkout. What a method does not know, such as
    uncertainty, the answer leaves out.

    Exit status, the worst of the files: 0 answered, 4 nothing found, 2 bad input or a method that cannot run.
    """
    options = of.checked(context.params)
    try:
        status = _installed("paper")(method, files, options, as_json)
    except ModuleNotFoundError:
        complain("paper", NOT_IN_WHEEL)
        raise typer.Exit(BAD_INPUT) from None
    except (ImportError, RuntimeError) as error:
        complain("paper", str(error))
        raise typer.Exit(BAD_INPUT) from None
    raise typer.Exit(status)


def bench(context: typer.Context) -> None:
    """Measure primfit and other libraries on the same clouds."""
    try:
        command = _installed("bench")
    except ImportError as error:
        complain("bench", str(error))
        raise typer.Exit(BAD_INPUT) from None
    raise typer.Exit(command(context.args))


def _installed(command: str) -> Callable[..., Any]:
    """The function of a command in a part that `app` does not import, found by its entry point."""
    from importlib.metadata import entry_points

    for entry in entry_points(group="primfit.commands", name=command):
        function: Callable[..., Any] = entry.load()
        return function
    raise ImportError("this installation is older than the command: pip install --editable . again")
