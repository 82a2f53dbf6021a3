"""`GET /capabilities` tells what the code and the settings say."""

import json
import math
from typing import Any, get_args

from primfit.app.exports import FORMATS as ARTIFACTS
from primfit.app.readers import FORMATS
from primfit.app.service.media_types import MEDIA_TYPES
from primfit.app.wire.schemas import Capabilities, FitOptions
from primfit.fitting.names import KINDS, Criterion
from primfit.models import CLASSIFIERS
from tests.paths import EXAMPLES

SMALL = json.loads((EXAMPLES / "request.json").read_bytes())


def test_it_lists_what_there_is(service: Any) -> None:
    told = service.client.get("/capabilities").json()
    Capabilities.model_validate(told, strict=True)
    assert tuple(told["kinds"]) == KINDS
    assert tuple(told["classifiers"]) == CLASSIFIERS
    assert tuple(told["criteria"]) == get_args(Criterion)
    assert told["artifacts"] == list(ARTIFACTS)
    assert [option["name"] for option in told["options"]] == list(FitOptions.model_fields)
    assert told["versions"] == service.client.get("/version").json()
    assert told["extras"].keys() >= {"bench", "train"} and told["extras"].keys().isdisjoint({"dev", "fuzz"})
    assert told["extras"]["bench"] is True  # matplotlib, which the tests need


def test_every_media_type_of_a_format_is_read() -> None:
    assert {media_type for format in FORMATS for media_type in format.media_types} <= set(MEDIA_TYPES)
    extensions = [extension for format in FORMATS for extension in format.extensions]
    assert len(extensions) == len(set(extensions))


def test_limits_are_those_of_the_service(strict_service: Any) -> None:
    limits = strict_service.client.get("/capabilities").json()["limits"]
    assert limits == {
        "max_body_bytes": 2**20,
        "max_points": 20_000,
        "max_json_points": 1000,
        "points_by_criterion": dict.fromkeys(get_args(Criterion), 20_000),
        "fit_time_limit": 3.0,
        "receive_timeout": 3.0,
        "queue_size": 1,
        "rate_limit": None,
    }


def test_the_range_of_an_option_is_the_one_that_is_held(service: Any) -> None:
    options = {option["name"]: option for option in service.client.get("/capabilities").json()["options"]}
    assert (options["seed"]["minimum"], options["seed"]["maximum"]) == (0, 2**63 - 1)
    assert options["classifier"]["values"] == list(CLASSIFIERS) and options["classifier"]["type"] == "string"
    assert options["kinds"]["values"] == options["kinds"]["default"] == list(KINDS)
    for allowed, refused in [
        ({"seed": options["seed"]["maximum"]}, {"seed": options["seed"]["maximum"] + 1}),
        ({"max_error": options["max_error"]["maximum"]}, {"max_error": math.nextafter(1.0, 2.0)}),
        ({"max_error": 1e-9}, {"max_error": options["max_error"]["exclusive_minimum"]}),
    ]:
        assert service.client.post("/fit", json={**SMALL, "options": allowed}).status_code == 200
        assert service.client.post("/fit", json={**SMALL, "options": refused}).status_code == 422


def test_the_example_is_one(service: Any) -> None:
    paths = service.client.get("/openapi.json").json()["paths"]
    content = paths["/capabilities"]["get"]["responses"]["200"]["content"]["application/json"]
    shown = Capabilities.model_validate(content["examples"]["defaults"]["value"], strict=True)
    told = Capabilities.model_validate(service.client.get("/capabilities").json())
    assert (shown.jobs, told.jobs) == (False, True)  # the service of the tests keeps some
    here = {"jobs": told.jobs, "extras": told.extras, "versions": told.versions}
    assert shown.model_copy(update=here) == told
