"""Fuzz one target: `python -m tests.fuzz.one NAME [FOLDER ...] [flags of libFuzzer]`."""

import sys

import atheris

with atheris.instrument_imports(
    include=["primfit.app", "laspy", "lazrs", "python_multipart", "pye57", "zipfile"]
):
    import laspy as laspy
    import pye57 as pye57

    from tests.fuzz.checked import check


def main() -> None:
    name = sys.argv.pop(1)
    atheris.Setup(sys.argv, lambda data: check(name, data))
    atheris.Fuzz()


if __name__ == "__main__":
    main()
