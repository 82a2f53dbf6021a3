"""Errors as problem documents (RFC 9457): one table from exceptions to statuses.

Nothing of the input is repeated but the names of fields, which are cut, and options that are out of range,
which are numbers.
"""

import errno
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import orjson
from pydantic import ValidationError
from pydantic_core import ErrorDetails
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from primfit.fitting import names
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError

from ..exports.fitted import NothingToExportError
from ..readers.errors import (
    SHOWN,
    FieldError,
    InvalidPointsError,
    TooLargeError,
    UnreadableFileError,
    describe,
)
from ..readers.packed import CODINGS

MEDIA_TYPE = "application/problem+json"
NOT_A_PAGE = {"Content-Security-Policy": "default-src 'none'; frame-ancestors 'none'"}
"""For a browser that is led to a refusal: it holds nothing to run, nor to show inside of another page."""
# What pydantic says in terms of Python, or with the input in it.
_WORDS = {
    "extra_forbidden": "unknown field",
    "model_type": "an object is needed",
    "model_attributes_type": "an object is needed",
    "union_tag_not_found": "kind is missing",
    "union_tag_invalid": f"kind is unknown; allowed are {', '.join(names.KINDS)}",
}
# By the names that pydantic has for limits.
_OUT_OF_RANGE = {"gt": "greater than", "ge": "at least", "lt": "less than", "le": "at most"}
# 20 errors of these lengths, every character escaped, fit into 24 KiB with the rest.
_FIELD_LENGTH, _VALUE_LENGTH, _MESSAGE_LENGTH, _DETAIL_LENGTH = 80, 60, 300, 400


class ServiceError(Exception):
    """A request that the service does not carry out, for a reason that is not in the cloud."""


class UnsupportedMediaTypeError(ServiceError):
    """The body is of a type that is not read."""


class UnsupportedCodingError(UnsupportedMediaTypeError):
    """The body is packed in a way that is not read."""


class BodyTimeoutError(ServiceError):
    """The client stopped sending before its body was complete."""


class MalformedRequestError(ServiceError):
    """What came is not HTTP, or its end is not certain."""


class HeadTooLargeError(ServiceError):
    """The request line and the headers are over the limit."""


class HeadTimeoutError(ServiceError):
    """The client did not send the head of a request in time."""


class TooManyConnectionsError(ServiceError):
    """All connections that the service takes have a request under way."""


class WrongHostError(ServiceError):
    """The request is addressed to a name that is not one of this service."""


class ForeignOriginError(ServiceError):
    """A page of another origin asks, which may not."""


class BodyTooLargeError(TooLargeError):
    """The body is over the limit; the rest of it is not read, so the connection ends."""


class WorkerDiedError(ServiceError):
    """The process that worked on the request ended."""


class TimeLimitError(ServiceError):
    """Reading and fitting took longer than allowed."""


class NotReadyError(ServiceError):
    """The workers are not warm yet, or the service is about to stop."""


class StoppingError(ServiceError):
    """The service stopped before the answer was ready."""


class UnauthorizedError(ServiceError):
    """No API key came with the request, or one that is not known."""


class NoSuchJobError(ServiceError):
    """No job of this id belongs to the client."""


class JobsOffError(ServiceError):
    """The service keeps no jobs."""


class TooManyJobsError(ServiceError):
    """The client has as many jobs, or bytes in them, as it may."""


class IdempotencyKeyReusedError(ServiceError):
    """Another job came with the same Idempotency-Key before."""


class JobsUnavailableError(ServiceError):
    """The database of the jobs does not answer."""


class NoSuchTicketError(ServiceError):
    """The upload ticket is unknown, has no file yet, or its time is over."""


class TicketUsedError(ServiceError):
    """A file was, or is being, uploaded with the ticket."""


class HeaderError(ServiceError):
    """A refusal whose headers depend on the request or the moment."""

    def __init__(self, message: str, headers: Mapping[str, str] | None = None) -> None:
        super().__init__(message)
        self.headers = dict(headers or {})


class BusyError(HeaderError):
    """Too many requests wait for a worker already, or one has waited too long."""


class InsufficientStorageError(HeaderError):
    """There is no room to keep a body, or points of a batch."""


class RateLimitedError(HeaderError):
    """The client has asked as often as it may for now."""


class AlreadyAnsweredError(HeaderError):
    """The answer would be the one that the client has already."""


class InvalidOptionsError(ValueError):
    """Options that are unknown, of the wrong type, or given twice."""

    def __init__(self, errors: Sequence[FieldError]) -> None:
        first = f"{errors[0].field[:_FIELD_LENGTH]}: {errors[0].message}"
        super().__init__(first if len(errors) == 1 else f"{len(errors)} mistakes, the first: {first}")
        self.errors = tuple(errors)


@dataclass(frozen=True)
class Kind:
    """One type of problem: status, the last part of its `type` URI, and title."""

    status: int
    slug: str
    title: str
    headers: Mapping[str, str] = field(default_factory=dict)

    @property
    def uri(self) -> str:
        return f"urn:primfit:problem:{self.slug}"


_RETRY = {"Retry-After": "1"}
# Room comes back when other requests end; a disk that is full may stay so.
_RETRY_LATER = {"Retry-After": "10"}
_CLOSE = {"Connection": "close"}
KINDS: dict[type[Exception], Kind] = {
    InvalidPointsError: Kind(422, "invalid-points", "The points are not a cloud that can be fitted"),
    InvalidPointCloudError: Kind(422, "invalid-points", "The points are not a cloud that can be fitted"),
    TooLargeError: Kind(413, "too-large", "The input is over a limit"),
    BodyTooLargeError: Kind(413, "too-large", "The input is over a limit", _CLOSE),
    UnreadableFileError: Kind(422, "unreadable-input", "The input cannot be read"),
    InvalidOptionsError: Kind(422, "invalid-options", "An option is unknown or out of range"),
    InvalidOptionError: Kind(422, "invalid-options", "An option is unknown or out of range"),
    NothingToExportError: Kind(422, "nothing-to-export", "The answer holds nothing to export"),
    UnsupportedMediaTypeError: Kind(
        415, "unsupported-media-type", "The media type of the body is not supported"
    ),
    UnsupportedCodingError: Kind(
        415,
        "unsupported-media-type",
        "The content encoding of the body is not supported",
        {"Accept-Encoding": ", ".join(CODINGS)},
    ),
    BodyTimeoutError: Kind(408, "body-timeout", "The body did not arrive", _CLOSE),
    BusyError: Kind(503, "busy", "Too many requests are waiting", _RETRY),
    InsufficientStorageError: Kind(507, "no-space", "There is no room to keep the input", _RETRY_LATER),
    NotReadyError: Kind(503, "not-ready", "The service is not ready", _RETRY),
    StoppingError: Kind(503, "stopping", "The service stopped", _RETRY | _CLOSE),
    UnauthorizedError: Kind(
        401, "unauthorized", "An API key is needed", {"WWW-Authenticate": 'Bearer realm="primfit"'}
    ),
    RateLimitedError: Kind(429, "rate-limited", "Too many requests of this client"),
    AlreadyAnsweredError: Kind(412, "already-answered", "You have this answer already"),
    WorkerDiedError: Kind(503, "worker-died", "The worker process ended; it is being replaced", _RETRY),
    MalformedRequestError: Kind(400, "malformed-request", "The request is not well-formed", _CLOSE),
    HeadTooLargeError: Kind(431, "head-too-large", "The head of the request is too large", _CLOSE),
    HeadTimeoutError: Kind(408, "head-timeout", "The head of the request did not arrive", _CLOSE),
    TooManyConnectionsError: Kind(
        503, "too-many-connections", "Too many connections are at work", _RETRY | _CLOSE
    ),
    WrongHostError: Kind(421, "wrong-host", "The request is addressed to another host"),
    ForeignOriginError: Kind(403, "foreign-origin", "Pages of this origin may not ask"),
    NoSuchJobError: Kind(404, "no-such-job", "No such job"),
    JobsOffError: Kind(404, "jobs-off", "This service keeps no jobs"),
    TooManyJobsError: Kind(429, "too-many-jobs", "Too many jobs of this client", {"Retry-After": "60"}),
    IdempotencyKeyReusedError: Kind(
        422, "idempotency-key-reused", "Another job came with this Idempotency-Key"
    ),
    JobsUnavailableError: Kind(503, "jobs-unavailable", "The database of the jobs does not answer", _RETRY),
    NoSuchTicketError: Kind(404, "no-such-ticket", "No such upload ticket"),
    TicketUsedError: Kind(409, "ticket-used", "The upload ticket was used"),
    TimeLimitError: Kind(504, "time-limit", "Reading and fitting took too long"),
}
INTERNAL = Kind(500, "internal-error", "The service failed; the request may be valid")
_HTTP = {
    404: Kind(404, "not-found", "No such path"),
    405: Kind(405, "method-not-allowed", "No such method here"),
}


@dataclass(frozen=True)
class Problem:
    """A problem document, ready to be sent."""

    slug: str
    status: int
    content: bytes
    headers: Mapping[str, str]


def problem(error: Exception, instance: str) -> Problem:
    """The problem document of an exception; `instance` identifies the request."""
    error = no_room(error) or error
    kind = _kind(error)
    detail, errors = _describe(error)
    document: dict[str, Any] = {
        "type": kind.uri,
        "title": kind.title,
        "status": kind.status,
        "detail": plain(detail, _DETAIL_LENGTH),
        "instance": instance,
        "errors": [_field(error) for error in errors[:SHOWN]],
    }
    headers = {**kind.headers, **(getattr(error, "headers", None) or {}), **NOT_A_PAGE}
    return Problem(kind.slug, kind.status, orjson.dumps(document), headers)


def respond(request: Request, error: Exception) -> Response:
    """The problem document of an exception as the response to a request."""
    request_id = getattr(request.state, "request_id", "unknown")
    refused = problem(error, f"/requests/{request_id}")
    request.state.facts = {**getattr(request.state, "facts", {}), "problem": refused.slug}
    headers = {**refused.headers, "X-Request-Id": request_id}
    return Response(refused.content, refused.status, headers, MEDIA_TYPE)


def option_errors(error: ValidationError, prefix: str, allowed: Sequence[str]) -> list[FieldError]:
    """What pydantic found in the options, in our words."""
    return [
        FieldError(
            _path(prefix, found["loc"]),
            _what_is_wrong(found, allowed),
            describe(found["input"]),
        )
        for found in error.errors(include_url=False)
    ]


def _what_is_wrong(found: ErrorDetails, allowed: Sequence[str]) -> str:
    if found["type"] == "extra_forbidden" and len(found["loc"]) == 1:
        return f"unknown option; allowed are {', '.join(allowed)}"
    for name, limit in found.get("ctx", {}).items():
        if name in _OUT_OF_RANGE:
            held = f"it must be {_OUT_OF_RANGE[name]} {str(limit).removesuffix('.0')}"
            return f"{found['loc'][-1]} is {float(found['input']):g}; {held}"
    return _WORDS.get(found["type"], found["msg"])


def _path(prefix: str, steps: Sequence[int | str]) -> str:
    if steps[0] == "initial_guess":
        steps = [*steps[:1], *steps[2:]]  # the second is its kind, by which pydantic chose the model
    path = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps)
    return (prefix + path).removeprefix(".")


_FULL = (errno.ENOSPC, errno.EDQUOT)
_NO_MORE_FILES = (errno.EMFILE, errno.ENFILE, errno.EROFS)


def no_room(error: Exception) -> InsufficientStorageError | None:
    """What the system says where it has no room for a file, in our terms; None for anything else."""
    if isinstance(error, OSError) and error.errno in (*_FULL, *_NO_MORE_FILES):
        return _no_room(error, "temporary files")
    return None


def _no_room(error: OSError, what: str) -> InsufficientStorageError:
    if error.errno in _FULL:
        return InsufficientStorageError(f"the disk for {what} is full; try again later")
    return InsufficientStorageError(f"{what} cannot be written now ({error.strerror}); try again later")


@contextmanager
def room_needed(what: str = "temporary files") -> Iterator[None]:
    """Raise `InsufficientStorageError` where a file cannot be made or written, whatever the system says."""
    try:
        yield
    except OSError as error:
        if error.errno is None:  # as that of a time limit
            raise
        raise _no_room(error, what) from error


def _kind(error: Exception) -> Kind:
    if isinstance(error, HTTPException):
        return _HTTP.get(error.status_code) or Kind(
            error.status_code, "http-error", "The request was refused"
        )
    return next((KINDS[base] for base in type(error).__mro__ if base in KINDS), INTERNAL)


def _describe(error: Exception) -> tuple[str, Sequence[FieldError]]:
    match error:
        case UnreadableFileError():
            return error.message, error.errors
        case InvalidOptionsError():
            return str(error), error.errors
        case InvalidPointCloudError():
            return str(error), [FieldError(error.field, str(error))]
        case InvalidOptionError():
            return str(error), [FieldError(f"options.{error.field}", str(error))]
        case NothingToExportError():
            return str(error), [FieldError("artifacts", str(error))]
        case ServiceError():
            return str(error), []
        case HTTPException():
            return str(error.detail), []
        case _:
            return "an unexpected error; the log of the service tells more under this instance", []


def _field(error: FieldError) -> dict[str, str]:
    shown = {"field": plain(error.field, _FIELD_LENGTH), "message": plain(error.message, _MESSAGE_LENGTH)}
    return shown if error.value is None else {**shown, "value": plain(error.value, _VALUE_LENGTH)}


def plain(text: str, length: int) -> str:
    """At most so many printable ASCII characters: names of fields come from outside."""
    text = text[:length]
    if text.isascii() and text.isprintable():
        return text
    return "".join(letter if " " <= letter <= "~" else "?" for letter in text)
