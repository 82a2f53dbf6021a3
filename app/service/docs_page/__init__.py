"""The page at /docs: one document, drawn from openapi.json by its own script alone."""

import base64
from functools import cache
from hashlib import sha256
from pathlib import Path

_FOLDER = Path(__file__).parent
_SCRIPTS = ("elements.js", "fields.js", "picture.js", "archive.js", "answer.js", "trial.js", "page.js")
"""Each uses those before it."""


@cache
def page() -> tuple[str, dict[str, str]]:
    """The document, and headers that forbid it any script but its own, and any other service."""
    script = '\n"use strict";\n' + "\n".join(map(_text, _SCRIPTS))
    digest = base64.b64encode(sha256(script.encode()).digest()).decode()
    policy = (
        f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; connect-src 'self'; "
        "img-src data:; frame-src 'self'; base-uri 'none'; form-action 'none'"
    )
    document = _text("page.html").replace("{style}", f"\n{_text('style.css')}").replace("{script}", script)
    return document, {"Content-Security-Policy": policy}


def _text(name: str) -> str:
    return (_FOLDER / name).read_text(encoding="utf-8")
