"""`primfit mcp`: tools for agents, by the Model Context Protocol."""

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..status import BAD_INPUT, complain

if TYPE_CHECKING:
    from ...agents.places import Places

NEEDED = ("mcp", "PIL")
"""What the extra brings along."""


def mcp(
    root: Annotated[
        list[Path] | None,
        typer.Option(
            help="Tools may read files under this folder (repeatable). By default it is the working "
            "directory, with --http there is none.",
            file_okay=False,
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option(help="The tool export writes into this folder.", file_okay=False)
    ] = None,
    http: Annotated[
        bool, typer.Option("--http", help="Serve streamable HTTP at /mcp, not standard input and output.")
    ] = False,
    host: Annotated[
        str | None, typer.Option(help="Address to listen on, with --http.", show_default="127.0.0.1")
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="Port, with --http; 0 takes a free one.", show_default="8000"),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="Processes that read and fit.", show_default="one a core, up to 4"),
    ] = None,
) -> None:
    """Serve tools for agents, by the Model Context Protocol (MCP).

    An agent names files by their paths; clouds never go through its context. Limits and keys are those of the
    service, see 'primfit settings'.
    """
    from ...service.settings import SettingsError, load

    given = {"host": host, "port": port, "workers": workers}
    flags = {name: value for name, value in given.items() if value is not None}
    try:
        settings = load(**flags)
        places = _places(root, output, http)
    except SettingsError as error:
        raise _refused(*error.complaints) from None
    except OSError as error:
        raise _refused(str(error)) from None
    if not all(map(find_spec, NEEDED)):
        raise _refused("the Model Context Protocol needs an extra: pip install 'primfit[mcp]'")
    if not http:
        from ...agents.server import serve_stdio

        serve_stdio(settings, places)
        return
    from ...agents.http import serve_http
    from ...service.server import ListenError

    try:
        serve_http(settings, places, flags)
    except SettingsError as error:
        raise _refused(*error.complaints) from None
    except ListenError as error:
        raise _refused(str(error)) from None


def _places(root: list[Path] | None, output: Path | None, http: bool) -> "Places":
    """The folders, which have to be there; raises `OSError`."""
    from ...agents.places import Places
    from ...agents.roots import Roots

    if output is not None and not output.is_dir():
        raise NotADirectoryError(f"--output: {output} is no folder")
    folders = root or ([] if http else [Path.cwd()])
    return Places(Roots.of(folders), None if output is None else output.resolve())


def _refused(*complaints: str) -> typer.Exit:
    for complaint in complaints:
        complain("mcp", complaint)
    return typer.Exit(BAD_INPUT)
