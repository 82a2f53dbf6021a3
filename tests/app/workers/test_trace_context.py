"""traceparent as W3C Trace Context has it, and the lines of workers that name the trace."""

import pytest

from primfit.app.workers.trace_context import Caller, caller

TRACE, SPAN = "0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331"
GOOD = f"00-{TRACE}-{SPAN}-01"


def _of(*parents: str) -> Caller | None:
    return caller([(b"traceparent", parent.encode("latin-1")) for parent in parents])


def test_a_caller_is_told_with_its_state() -> None:
    state = [(b"tracestate", b"one=1"), (b"accept", b"*/*"), (b"tracestate", b"two=2")]
    headers = [(b"host", b"localhost"), (b"traceparent", GOOD.encode()), *state]
    assert caller(headers) == Caller(TRACE, SPAN, "01", "one=1,two=2")


def test_a_later_version_may_hold_more() -> None:
    assert _of(f"01-{TRACE}-{SPAN}-01-more") == Caller(TRACE, SPAN, "01", "")


@pytest.mark.parametrize(
    "parents",
    [
        (),
        ("",),
        (GOOD, GOOD),
        (f"{GOOD}-more",),
        (f"{GOOD}-",),
        (f"ff-{TRACE}-{SPAN}-01",),
        (f"00-{TRACE.upper()}-{SPAN}-01",),
        (f"00-{'0' * 32}-{SPAN}-01",),
        (f"00-{TRACE}-{'0' * 16}-01",),
        (f"00-{TRACE}-{SPAN}",),
        (f"00-{TRACE}-{SPAN}-1",),
        (f"00-{TRACE[:-1]}é-{SPAN}-01",),
        (f"01-{TRACE}-{SPAN}-01more",),
        (f"{GOOD}\n",),
    ],
)
def test_what_is_not_one_is_left_aside(parents: tuple[str, ...]) -> None:
    assert _of(*parents) is None
