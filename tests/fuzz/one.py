"""Fuzz one target: `python -m tests.fuzz.one NAME [FOLDER ...] [flags of libFuzzer]`.

To instrument takes a second for every twenty modules: only those are that read input, and what they need
beside it is imported before or after them.
"""

import importlib
import sys

import atheris

_ROOTS = ["primfit", "laspy", "pye57", "python_multipart", "zipfile"]
_READERS = ["primfit.app.readers", "pye57", "zipfile"]
_WIRE = ["primfit.app.wire.options", "primfit.app.wire.multipart"]
_NEEDED = ["primfit.app.wire.problems", "primfit.app.wire.schemas", "lzf", "laspy", "scipy.spatial.transform"]


def _import(modules: list[str]) -> None:
    for module in modules:
        importlib.import_module(module)


def _fuzz(name: str) -> None:
    with atheris.instrument_imports(include=_ROOTS):
        _import([*_READERS, *(["laspy"] if name == "las" else [])])
    _import(_NEEDED)
    with atheris.instrument_imports(include=_ROOTS):
        _import(_WIRE)
    from tests.fuzz.checked import check

    atheris.Setup(sys.argv, lambda data: check(name, data))
    atheris.Fuzz()


if __name__ == "__main__":
    _fuzz(sys.argv.pop(1))
