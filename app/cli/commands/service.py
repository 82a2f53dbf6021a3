"""`primfit serve`, and what it is set to and promises: `settings`, `openapi`."""

import sys
from typing import Annotated

import typer

from ..status import BAD_INPUT, complain


def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on.", show_default="127.0.0.1")] = None,
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="Port; 0 takes a free one.", show_default="8000")
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="Processes that read and fit.", show_default="one a core, up to 4"),
    ] = None,
    demo: Annotated[bool, typer.Option("--demo", help="Post an example cloud and print its answer.")] = False,
) -> None:
    """Serve the REST API.

    What is not given here comes from the environment or a file, see 'primfit settings'.
    """
    from ...engine.team import process_context
    from ...workers import PRELOAD

    # First of all: what the workers need is imported beside what the service needs.
    process_context(PRELOAD)
    from ...service.server import ListenError, serve
    from ...service.settings import SettingsError

    try:
        serve(host, port, workers, demo)
    except SettingsError as error:
        for complaint in error.complaints:
            complain("serve", complaint)
        raise typer.Exit(BAD_INPUT) from None
    except ListenError as error:
        complain("serve", str(error))
        raise typer.Exit(BAD_INPUT) from None


def settings(
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Print what there is to set, as in docs/settings.md.")
    ] = False,
) -> None:
    """Check the settings of the service and print those in force.

    They come from PRIMFIT_<NAME> in the environment, else from the TOML file that PRIMFIT_CONFIG names.
    What is printed may be kept as such a file; API keys are left out.
    """
    from ...service.settings import SettingsError, load
    from ...service.settings_page import in_force, page

    if markdown:
        print(page(), end="")
        return
    try:
        print(in_force(load()), end="")
    except SettingsError as error:
        for complaint in error.complaints:
            complain("settings", complaint)
        raise typer.Exit(BAD_INPUT) from None


def openapi() -> None:
    """Print the OpenAPI document of the service.

    Clients are generated from it.
    """
    from ...service.api import create_app
    from ...service.openapi import as_text

    sys.stdout.buffer.write(as_text(create_app()))
