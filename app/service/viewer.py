"""The page at `/`, a fit to look at: the files that `make viewer` builds of app/viewer."""

import gzip
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from starlette.requests import Request
from starlette.responses import Response

ROOT, PREFIX = "/", "/viewer/"
_BUILT = Path(__file__).parent.parent / "viewer" / "built"
_MEDIA_TYPES = {
    "viewer.js": "text/javascript",
    "reader.js": "text/javascript",
    "viewer.css": "text/css",
    "licenses.txt": "text/plain",
}
PATHS = tuple(PREFIX + name for name in _MEDIA_TYPES)
POLICY = (
    "default-src 'none'; script-src 'self'; worker-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class _File(NamedTuple):
    content: bytes
    packed: bytes
    tag: str


def page(request: Request) -> Response:
    """The document, with headers that forbid it everything from elsewhere."""
    return _respond(request, "index.html", "text/html; charset=utf-8")


def part(request: Request, name: str) -> Response | None:
    """A script, the style, or the licenses of what is in them; None where there is none of this name."""
    media_type = _MEDIA_TYPES.get(name)
    return None if media_type is None else _respond(request, name, f"{media_type}; charset=utf-8")


def _respond(request: Request, name: str, media_type: str) -> Response:
    file = _file(name)
    headers = {
        "Content-Security-Policy": POLICY,
        "Cache-Control": "no-cache",
        "ETag": file.tag,
        "Vary": "Accept-Encoding",
    }
    if file.tag in request.headers.get("if-none-match", ""):
        return Response(None, 304, headers)
    if "gzip" not in request.headers.get("accept-encoding", ""):
        return Response(file.content, headers=headers, media_type=media_type)
    return Response(file.packed, headers=headers | {"Content-Encoding": "gzip"}, media_type=media_type)


@cache
def _file(name: str) -> _File:
    content = (_BUILT / name).read_bytes()
    return _File(content, gzip.compress(content, mtime=0), f'"{sha256(content).hexdigest()[:32]}"')
