"""The command `primfit`, also as `python -m primfit`."""

import sys

INTERRUPTED = 130
"""As of all commands: `app.cli.status` has it, too, which may not be there yet."""


def main() -> None:
    """Entry point; Ctrl-C is one line and no traceback while the program is still being loaded, too."""
    try:
        from primfit.app.cli.commands import main

        main()
    except KeyboardInterrupt:
        sys.stderr.write("primfit: interrupted\n")
        raise SystemExit(INTERRUPTED) from None


if __name__ == "__main__":
    main()
