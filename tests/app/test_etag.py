"""Equal requests have equal tags, and a client that names one is not fitted for again."""

import json
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from primfit.app.wire.etag import names

EXAMPLES = Path(__file__).parents[2] / "app" / "examples"
CSV = (EXAMPLES / "cylinder.csv").read_bytes()
SMALL = json.loads((EXAMPLES / "request.json").read_bytes())


def _again(service: Any, condition: str | None = None, query: str = "", body: bytes = CSV) -> httpx.Response:
    headers = {"Content-Type": "text/csv"} | ({} if condition is None else {"If-None-Match": condition})
    return service.client.post(f"/fit{query}", content=body, headers=headers)


def test_equal_requests_have_equal_tags(service: Any) -> None:
    tags = {_again(service).headers["etag"] for _ in range(3)}
    assert len(tags) == 1
    (tag,) = tags
    assert tag.startswith('"') and tag.endswith('"')
    assert _again(service, query="?seed=0").headers["etag"] == tag


def test_whatever_changes_the_answer_changes_the_tag(service: Any, cylinder: np.ndarray) -> None:
    rows = [",".join(map(repr, row)) for row in cylinder.tolist()]
    bodies = [CSV, CSV[:-40].rpartition(b"\n")[0]]
    for normal in ("0,0,1", "0,1,1"):
        lines = ["x,y,z,nx,ny,nz", *(f"{row},{normal}" for row in rows)]
        bodies.append("\n".join(lines).encode())
    responses = [_again(service, body=body) for body in bodies]
    responses += [_again(service, query=query) for query in ("?seed=1", "?kinds=cylinder", "?classifier=knn")]
    responses.append(service.client.post("/fit", json={"points": cylinder.tolist()}))
    weights = {"points": cylinder.tolist(), "weights": [1.0] * 299 + [2.0]}
    responses.append(service.client.post("/fit", json=weights))
    assert {response.status_code for response in responses} == {200}
    assert len({response.headers["etag"] for response in responses}) == len(responses)


@pytest.mark.parametrize("form", ["{}", "W/{}", '"other", {}', '"a,b" , W/{}, "c"', "*"])
def test_the_answer_that_a_client_has_is_not_made_again(service: Any, form: str) -> None:
    tag = _again(service).headers["etag"]
    response = _again(service, form.format(tag))
    assert response.status_code == 412
    assert response.json()["type"] == "urn:primfit:problem:already-answered"
    assert response.headers["etag"] == tag
    assert "fit;" not in response.headers["server-timing"]


@pytest.mark.parametrize("condition", ['"other"', "", "nonsense", '"*"', 'W/"'])
def test_another_tag_does_not_matter(service: Any, condition: str) -> None:
    assert _again(service, condition).status_code == 200


def test_several_headers_are_one_list(service: Any) -> None:
    tag = _again(service).headers["etag"]
    headers = [("Content-Type", "text/csv"), ("If-None-Match", '"other"'), ("If-None-Match", tag)]
    assert service.client.post("/fit", content=CSV, headers=headers).status_code == 412


def test_a_tag_of_other_options_does_not_match(service: Any) -> None:
    tag = _again(service).headers["etag"]
    assert _again(service, tag, "?seed=1").status_code == 200


@pytest.mark.parametrize(("query", "body"), [("?seed=one", CSV), ("", b"1,2\n"), ("?nothing=1", CSV)])
def test_what_is_wrong_with_a_request_is_said_first(service: Any, query: str, body: bytes) -> None:
    assert _again(service, "*", query, body).status_code == 422


def test_only_a_whole_tag_is_a_name() -> None:
    assert names('"abc"', '"abc"') and names('W/"abc"', '"abc"') and names(" * ", '"abc"')
    assert not names("abc", '"abc"') and not names('"ab"', '"abc"') and not names("", '"abc"')
