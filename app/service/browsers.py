"""Scripts of other web pages: which may ask, and what they may send and see (CORS)."""

from collections.abc import Collection

from fastapi import FastAPI
from starlette.middleware.cors import CORSMiddleware

_SENT = (
    "Authorization",
    "Content-Encoding",
    "Content-Type",
    "Idempotency-Key",
    "If-None-Match",
    "Last-Event-ID",
    "Prefer",
    "X-API-Key",
    "X-Request-Id",
)
_SEEN = (
    "Content-Disposition",
    "ETag",
    "Link",
    "Location",
    "Preference-Applied",
    "RateLimit",
    "RateLimit-Policy",
    "Retry-After",
    "Server-Timing",
    "X-Request-Id",
)


def share_with(app: FastAPI, origins: Collection[str]) -> None:
    """Let the scripts of these origins ask, if there are any.

    To be added outside of the guard: a browser asks for permission without a key.
    """
    if origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=list(origins),
            allow_methods=["DELETE", "GET", "HEAD", "POST"],
            allow_headers=_SENT,
            expose_headers=_SEEN,
        )
