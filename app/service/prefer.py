"""The header Prefer: what a client would like, and how long it would wait (RFC 7240)."""

import re

from starlette.datastructures import Headers

_QUOTED = r'"(?:\\.|[^"\\])*"?'
_BETWEEN_COMMAS = re.compile(rf'(?:[^,"]|{_QUOTED})+')
_BEFORE_SEMICOLON = re.compile(rf'(?:[^;"]|{_QUOTED})*')
_WAIT = re.compile(r"[0-9]{1,6}")


def preferences(headers: Headers) -> dict[str, str]:
    """The value of each preference, "" where it has none, by its name; parameters of them are left out.

    What stands there twice holds as it stands there first.
    """
    found: dict[str, str] = {}
    for preference in _BETWEEN_COMMAS.findall(",".join(headers.getlist("prefer"))):
        whole = _BEFORE_SEMICOLON.match(preference)
        name, _, value = whole[0].partition("=") if whole else ("", "", "")
        found.setdefault(name.strip().lower(), value.strip().strip('"'))
    return found


def wait(headers: Headers) -> float | None:
    """Seconds that the client would wait for the answer; None where it does not say, or says 0."""
    asked = preferences(headers).get("wait", "")
    return float(asked) or None if _WAIT.fullmatch(asked) else None
