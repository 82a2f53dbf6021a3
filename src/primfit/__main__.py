"""`python -m primfit`: the command `primfit`."""

from primfit.app.cli.commands import main

main()
