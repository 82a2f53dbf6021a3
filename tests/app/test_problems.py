"""Problem documents: bounded, and silent about the inside of the service and about the input."""

import json
from pathlib import Path

import pytest
from starlette.exceptions import HTTPException

from primfit.app.readers import FieldError, InvalidPointsError
from primfit.app.wire import problems
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError


def test_an_unexpected_error_tells_nothing() -> None:
    made = problems.problem(RuntimeError("secret of /etc/passwd"), "/requests/1")
    assert made.status == 500
    assert b"secret" not in made.content
    assert json.loads(made.content)["instance"] == "/requests/1"


def test_a_document_is_at_most_16_kib_whatever_the_errors_hold() -> None:
    errors = [FieldError("\U0001f600" * 10**5, "\0" * 10**5, '"' * 10**5)] * 1000
    made = problems.problem(InvalidPointsError("x" * 10**5, "\u20ac" * 10**6, errors=errors), "/requests/1")
    assert len(made.content) <= 24 * 1024
    assert len(json.loads(made.content)["errors"]) <= 20


def test_every_type_is_documented() -> None:
    page = (Path(__file__).parents[2] / "docs" / "api.md").read_text()
    rows = [line for line in page.splitlines() if line.startswith("| ")]
    for kind in (*problems.KINDS.values(), problems.INTERNAL):
        assert any(f"`{kind.slug}`" in row and str(kind.status) in row for row in rows), kind


@pytest.mark.parametrize(
    ("error", "status", "field"),
    [
        (InvalidPointCloudError("2 points given"), 422, "points"),
        (InvalidOptionError("seed is -1", "seed"), 422, "options.seed"),
        (problems.WorkerDiedError("gone"), 503, None),
        (problems.TimeLimitError("slow"), 504, None),
        (problems.BusyError("busy"), 503, None),
        (HTTPException(405), 405, None),
        (HTTPException(418), 418, None),
    ],
)
def test_each_error_has_its_status(error: Exception, status: int, field: str | None) -> None:
    made = problems.problem(error, "/requests/1")
    document = json.loads(made.content)
    assert made.status == document["status"] == status
    assert [shown["field"] for shown in document["errors"]] == ([field] if field else [])
