"""The OpenAPI document: valid, complete, the one in `docs`, and with examples that are answered."""

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from openapi_spec_validator import OpenAPIV31SpecValidator

from primfit.app.exports import NothingToExportError
from primfit.app.readers import CODINGS, read_file
from primfit.app.readers.errors import FieldError, InvalidPointsError, TooLargeError, UnreadableFileError
from primfit.app.service.api import create_app
from primfit.app.service.media_types import what_to_send
from primfit.app.service.openapi import as_text
from primfit.app.service.settings import Settings
from primfit.app.wire import problems
from primfit.app.wire.schemas import BatchSummary, FitOptions
from primfit.fitting.errors import InvalidPointCloudError
from tests.paths import DOCS, EXAMPLES

COMMITTED = DOCS / "openapi.json"
DOCUMENT = json.loads(COMMITTED.read_bytes())
OPERATIONS = {
    f"{method} {path}": operation
    for path, methods in DOCUMENT["paths"].items()
    for method, operation in methods.items()
}
# Other media types may hold bytes that JSON has no example of.
AS_TEXT = ("application/json", "multipart/form-data", "text/")


PROBLEMS: dict[str, dict[str, Exception]] = {
    "401": {"example": problems.UnauthorizedError("the API key is not known")},
    "408": {
        "example": problems.BodyTimeoutError(
            "nothing came for 30 s before the body was complete (1048576 bytes)"
        )
    },
    "404": {
        "no_such_job": problems.NoSuchJobError(
            "no job of yours has this id; jobs are removed some time after their end"
        ),
        "jobs_off": problems.JobsOffError(
            "jobs are kept where the setting jobs_path names a folder; POST /fit/batch works"
        ),
    },
    "412": {"example": problems.AlreadyAnsweredError("the answer would be the one that you named", {})},
    "413": {"example": TooLargeError("body", "the body is over 67108864 bytes, the limit of this service")},
    "415": {
        "media_type": problems.UnsupportedMediaTypeError(what_to_send("text/html")),
        "content_encoding": problems.UnsupportedCodingError(
            f"send the body as it is, or in one of {', '.join(CODINGS)}, once"
        ),
    },
    "422": {
        "points": InvalidPointsError(
            "points[17][2]", "not a finite number; every coordinate must be one", "NaN"
        ),
        "file": UnreadableFileError("file", "the header announces 2400 bytes of data, 1200 are there"),
        "options": problems.InvalidOptionsError(
            [
                FieldError(
                    "options.kind",
                    f"unknown option; allowed are {', '.join(FitOptions.model_fields)}",
                    "array of 1",
                )
            ]
        ),
        "artifacts": NothingToExportError("the answer is no_fit and holds no primitive to export"),
        "idempotency_key_reused": problems.IdempotencyKeyReusedError(
            "a job with another body or other options came with this key; a new job needs a new one"
        ),
    },
    "429": {
        "example": problems.RateLimitedError(
            "120 requests in 60 s are the limit of this service for one client", {}
        ),
        "too_many_jobs": problems.TooManyJobsError(
            "100 jobs are kept for you, and 100 is the limit; remove one with DELETE"
        ),
    },
    "500": dict.fromkeys(("example", "internal"), Exception()),
    "503": {
        "not_ready": problems.NotReadyError("no worker is warm yet"),
        "busy": problems.BusyError("64 requests with small clouds are waiting, the limit of this service"),
        "worker_died": problems.WorkerDiedError("the worker process ended while it worked on this request"),
        "stopping": problems.StoppingError("the service stopped before the answer was ready; ask again"),
        "jobs_unavailable": problems.JobsUnavailableError(
            "the database of the jobs does not answer; try again"
        ),
    },
    "504": {"example": problems.TimeLimitError("not done within 60 s; the work was stopped")},
    "507": {
        "example": problems.InsufficientStorageError("the disk for temporary files is full; try again later"),
        "disk_of_jobs": problems.InsufficientStorageError("the disk for jobs is full; try again later"),
    },
}


def _document(error: Exception) -> Any:
    return json.loads(problems.problem(error, "/requests/3f0c1f9e").content)


def test_the_examples_of_problems_are_what_the_service_says() -> None:
    made = {status: {name: _document(cause) for name, cause in of.items()} for status, of in PROBLEMS.items()}
    assert json.loads((EXAMPLES / "problems.json").read_bytes()) == made
    for status, documents in made.items():
        assert all(str(document["status"]) == status for document in documents.values())


def test_the_examples_of_lines_are_what_the_service_says() -> None:
    lines = json.loads((EXAMPLES / "lines.json").read_bytes())
    assert lines["problem"]["problem"] == _document(
        InvalidPointCloudError("2 points given; at least 3 are needed")
    )
    BatchSummary.model_validate(lines["summary"])


@pytest.mark.parametrize("name", ["few.csv", "few.tsv", "few.ply", "request_base64.json"])
def test_the_examples_of_files_hold_the_cloud_of_the_request(name: str) -> None:
    expected = json.loads((EXAMPLES / "request.json").read_bytes())["points"]
    np.testing.assert_array_equal(read_file(EXAMPLES / name).points, expected)


def _differences(one: Any, other: Any, where: str = "") -> Iterator[str]:
    """JSON pointers of what differs."""
    if isinstance(one, dict) and isinstance(other, dict):
        for name in one.keys() | other.keys():
            pointer = f"{where}/{name.replace('/', '~1')}"
            if name in one and name in other:
                yield from _differences(one[name], other[name], pointer)
            else:
                yield f"{pointer} ({'gone' if name in one else 'new'})"
    elif one != other:
        yield where


def test_the_document_in_docs_is_that_of_the_service() -> None:
    text = as_text(create_app(Settings()))
    changed = ", ".join(sorted(_differences(DOCUMENT, json.loads(text)))[:10])
    assert not changed, f"docs/openapi.json is out of date at {changed}; refresh it with: make openapi"
    assert COMMITTED.read_bytes() == text, "docs/openapi.json is out of order; refresh it with: make openapi"


def test_the_document_is_openapi_3_1() -> None:
    assert DOCUMENT["openapi"].startswith("3.1.")
    OpenAPIV31SpecValidator(DOCUMENT).validate()


@pytest.mark.parametrize("operation", OPERATIONS.values(), ids=OPERATIONS)
def test_an_operation_says_what_it_does_in_words_and_examples(operation: dict[str, Any]) -> None:
    assert operation["summary"].casefold() != operation["operationId"].replace("_", " ").casefold()
    assert operation["description"]
    assert set(operation["tags"]) <= {tag["name"] for tag in DOCUMENT["tags"]}
    assert len(operation["tags"]) == 1
    for parameter in operation["parameters"]:
        assert "$ref" in parameter or parameter["description"]
    for media_type, media in operation.get("requestBody", {"content": {}})["content"].items():
        assert media.get("examples") or not media_type.startswith(AS_TEXT), media_type
    for status, response in operation["responses"].items():
        assert response["description"]
        if status >= "400":
            assert response["content"]["application/problem+json"]["examples"], status


def _request_examples() -> Iterator[Any]:
    for name, operation in OPERATIONS.items():
        for media_type, media in operation.get("requestBody", {"content": {}})["content"].items():
            for title, example in media.get("examples", {}).items():
                yield pytest.param(name, media_type, example["value"], id=f"{name} {media_type} {title}")


@pytest.mark.parametrize(("name", "media_type", "value"), list(_request_examples()))
def test_an_example_of_a_request_is_answered(service: Any, name: str, media_type: str, value: Any) -> None:
    method, path = name.split()
    required = [parameter for parameter in OPERATIONS[name]["parameters"] if parameter.get("required")]
    params = {parameter["name"]: ",".join(parameter["example"]) for parameter in required}
    if media_type == "multipart/form-data":
        parts = [part for field, content in value.items() for part in _parts(field, content)]
        response = service.client.request(method, path, params=params, files=parts)
    else:
        content = value if isinstance(value, str) else json.dumps(value)
        headers = {"Content-Type": media_type}
        response = service.client.request(method, path, params=params, content=content, headers=headers)
    assert response.status_code == (202 if path == "/jobs" else 200), response.text


def _parts(field: str, content: Any) -> Iterator[tuple[str, tuple[str | None, bytes, str]]]:
    """The parts of a form: each file of a list in a part of its own, what is no text as JSON."""
    for item in content if isinstance(content, list) else [content]:
        if isinstance(item, str):
            yield field, ("cloud", item.encode(), "application/octet-stream")
        else:
            yield field, (None, json.dumps(item).encode(), "application/json")
