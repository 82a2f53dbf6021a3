"""Signs that a terminal or a pipe may not have: ASCII ones stand for them."""

import codecs
import sys

ASCII = {"±": "+-", "²": "^2", "─": "-", "µ": "u", "°": " deg"}


def spelt_out(error: UnicodeError) -> tuple[str, int]:
    """What is written of characters that an encoding lacks; a handler of `codecs`."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    missing = error.object[error.start : error.end]
    return "".join(ASCII.get(each, "?") for each in missing), error.end


def write_in_any_alphabet() -> None:
    """Let standard output write what its encoding lacks in other signs, as a file of Windows may need it."""
    codecs.register_error("primfit.spelt_out", spelt_out)
    reconfigure = getattr(sys.stdout, "reconfigure", None)
    if reconfigure is not None:
        reconfigure(errors="primfit.spelt_out")
