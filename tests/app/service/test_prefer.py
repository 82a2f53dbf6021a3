"""The header Prefer as RFC 7240 has it."""

import pytest
from starlette.datastructures import Headers

from primfit.app.service.prefer import preferences, wait


@pytest.mark.parametrize(
    ("given", "found", "seconds"),
    [
        ([], {}, None),
        (["respond-async"], {"respond-async": ""}, None),
        (['respond-async; foo="1", wait=10'], {"respond-async": "", "wait": "10"}, 10.0),
        (["Respond-Async", ' Wait = "5" ;x'], {"respond-async": "", "wait": "5"}, 5.0),
        (['a="1, wait=7; b", wait=8, wait=9'], {"a": "1, wait=7; b", "wait": "8"}, 8.0),
        (["respond-async; wait=3"], {"respond-async": ""}, None),
        (['a="\\", respond-async'], {"a": '\\", respond-async'}, None),
        (["wait=0, wait=4"], {"wait": "0"}, None),
        (["wait=-1"], {"wait": "-1"}, None),
        (["wait=1e400"], {"wait": "1e400"}, None),
        (["wait=\u0661"], {"wait": "\u0661"}, None),
    ],
)
def test_preferences_are_told_apart(given: list[str], found: dict[str, str], seconds: float | None) -> None:
    headers = Headers(raw=[(b"prefer", text.encode("utf-8")) for text in given])
    assert wait(headers) == seconds
    if "\u0661" not in "".join(given):  # headers are read as Latin-1
        assert preferences(headers) == found


def test_a_long_header_takes_no_long_time() -> None:
    preferences(Headers({"prefer": '"\\' * 16_000}))
    preferences(Headers({"prefer": '",;' * 10_000}))
