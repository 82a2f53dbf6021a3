"""The header that gives an answer the name of a file (RFC 6266)."""

import re
from urllib.parse import quote

_UNQUOTED = re.compile(r"[^ !#-\[\]-~]|%")


def attachment(name: str) -> str:
    """Content-Disposition of a file that a client keeps under this name.

    The name stands there in ASCII for old clients, and where that is not all of it, in UTF-8, too.
    """
    plain = _UNQUOTED.sub("_", name)
    header = f'attachment; filename="{plain}"'
    return header if plain == name else f"{header}; filename*=UTF-8''{quote(name, safe='')}"
