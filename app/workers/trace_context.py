"""The trace that a request belongs to, as its client tells it by the headers of W3C Trace Context."""

import re
from collections.abc import Iterable
from contextvars import ContextVar
from dataclasses import dataclass

TRACE_ID: ContextVar[str | None] = ContextVar("trace_id", default=None)
"""The trace that is worked for, on every line of the log that is written meanwhile."""

_HEADER = re.compile(
    r"(?!ff)([0-9a-f]{2})-(?!0{32})([0-9a-f]{32})-(?!0{16})([0-9a-f]{16})-([0-9a-f]{2})(-.*)?"
)
"""https://www.w3.org/TR/trace-context/#traceparent-header; only versions after 00 may go on."""


@dataclass(frozen=True)
class Caller:
    """The span from which a client asks, in hexadecimal digits; `state` is its header tracestate."""

    trace_id: str
    span_id: str
    flags: str
    state: str


def caller(headers: Iterable[tuple[bytes, bytes]]) -> Caller | None:
    """Who asks, by the headers of a request; None where they name no trace, or not well."""
    parents, states = [], []
    for name, value in headers:
        if name == b"traceparent":
            parents.append(value.decode("latin-1"))
        elif name == b"tracestate":
            states.append(value.decode("latin-1"))
    found = _HEADER.fullmatch(parents[0]) if len(parents) == 1 else None
    if found is None or (found[1] == "00" and found[5]):
        return None
    return Caller(found[2], found[3], found[4], ",".join(states))
