"""The media types of bodies and of answers."""

from ..readers import CODINGS, FORMATS

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
