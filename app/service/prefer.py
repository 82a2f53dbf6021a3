"""The header Prefer: how long a client would wait (RFC 7240)."""

import re

from starlette.datastructures import Headers

_WAIT = re.compile(r"""(?:^|[,;])\s*wait\s*=\s*"?(\d{1,6})"?\s*(?=[,;]|$)""", re.IGNORECASE)


def wait(headers: Headers) -> float | None:
    """Seconds that the client would wait for the answer; None where it does not say, or says 0."""
    found = _WAIT.search(",".join(headers.getlist("prefer")))
    return float(found[1]) or None if found else None
