"""The media types of bodies and of answers."""

from ..readers import CODINGS, FORMATS

RAW_TYPES = (
    "application/octet-stream",
    *(media_type for format in FORMATS if format.name != "json" for media_type in format.media_types),
    *(f"application/{coding}" for coding in CODINGS),
)
NDJSON = "application/x-ndjson"
MEDIA_TYPES = ("application/json", "multipart/form-data", *RAW_TYPES)
WHAT_IS_READ = f"send one of {', '.join(MEDIA_TYPES)}"
