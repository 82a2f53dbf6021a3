"""The media types of bodies and of answers."""

from starlette.requests import Request

from ..readers import CODINGS, FORMATS
from ..wire.problems import UnsupportedCodingError, UnsupportedMediaTypeError

RAW_TYPES = (
    "application/octet-stream",
    *(media_type for format in FORMATS if format.name != "json" for media_type in format.media_types),
    *(f"application/{coding}" for coding in CODINGS),
)
NDJSON = "application/x-ndjson"
MEDIA_TYPES = ("application/json", "multipart/form-data", *RAW_TYPES)
# What curl calls a body of which it is told nothing else.
_FORM = "application/x-www-form-urlencoded"


def what_to_send(media_type: str) -> str:
    """The way out for a request with a body of a type that is not read."""
    if media_type == _FORM:
        return (
            "send a file by curl --data-binary @FILE -H 'Content-Type: application/octet-stream', or by "
            f"curl -F file=@FILE; {_FORM}, as curl names it by itself, is not read, and curl -d takes the "
            "line ends out of it"
        )
    return f"send one of {', '.join(MEDIA_TYPES)}"


def media_type_of(request: Request) -> str:
    """That of the body; raises `UnsupportedMediaTypeError` for one that is not read."""
    media_type = (
        request.headers.get("content-type", "application/octet-stream").partition(";")[0].strip().lower()
    )
    if media_type not in MEDIA_TYPES:
        raise UnsupportedMediaTypeError(what_to_send(media_type))
    return media_type


def coding_of(request: Request) -> str | None:
    """How the body is packed: `gzip` (by its old name, too) or `zstd`, None if it is not."""
    names = ",".join(request.headers.getlist("content-encoding")).lower().split(",")
    names = [name.strip().replace("x-gzip", "gzip") for name in names]
    codings = [name for name in names if name not in ("", "identity")]
    if len(codings) > 1 or not set(codings) <= set(CODINGS):
        raise UnsupportedCodingError(f"send the body as it is, or in one of {', '.join(CODINGS)}, once")
    return codings[0] if codings else None
