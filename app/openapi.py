"""The OpenAPI document: what FastAPI cannot read off the routes, with real examples."""

from pathlib import Path
from typing import Any

import orjson
from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic.json_schema import models_json_schema

from app import problems
from app.capabilities import capabilities
from app.guard import OPEN, UNLIMITED
from app.options import OBJECTS
from app.readers import FORMATS
from app.readers.errors import FieldError, InvalidPointsError, TooLargeError, UnreadableFileError
from app.schemas import FitOptions, FitRequest, FitUpload, Problem, Versions
from app.settings import Settings

DESCRIPTION = (
    "Which geometric primitive is a segmented 3D point cloud - plane, sphere, cylinder, cone or torus - "
    "and with which parameters? Send a cloud to `POST /fit`."
)
RAW_TYPES = (
    "application/octet-stream",
    *(media_type for format in FORMATS if format.name != "json" for media_type in format.media_types),
)
MEDIA_TYPES = ("application/json", "multipart/form-data", *RAW_TYPES)
WHAT_IS_READ = f"send one of {', '.join(MEDIA_TYPES)}, without content encoding"

_EXAMPLES = Path(__file__).with_name("examples")
_REF = "#/components/schemas/{model}"
_EXAMPLE_ERRORS: dict[str, Exception] = {
    "412": problems.AlreadyAnsweredError("the answer would be the one that you named", {}),
    "408": problems.BodyTimeoutError("nothing came for 30 s before the body was complete (1048576 bytes)"),
    "413": TooLargeError("body", "the body is over 67108864 bytes, the limit of this service"),
    "415": problems.UnsupportedMediaTypeError(WHAT_IS_READ),
    "500": Exception(),
    "504": problems.TimeLimitError("not done after 60 s, the limit of this service; the work was stopped"),
}
_INVALID: dict[str, Exception] = {
    "points": InvalidPointsError("points[17][2]", "NaN is not JSON; every number must be finite", "NaN"),
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
}
_UNAVAILABLE: dict[str, Exception] = {
    "not_ready": problems.NotReadyError("no worker is warm yet"),
    "busy": problems.BusyError("64 requests are waiting, the limit of this service"),
    "worker_died": problems.WorkerDiedError("the worker process ended while it worked on this request"),
    "stopping": problems.StoppingError("the service stopped before the answer was ready; ask again"),
}
_UNAUTHORIZED = problems.UnauthorizedError("the API key is not known")
_LIMITED = problems.RateLimitedError("120 requests in 60 s are the limit of this service for one client", {})
# Each alone, or none at all: a service asks for keys only where it is told to.
SECURITY_SCHEMES = {
    "bearer": {
        "type": "http",
        "scheme": "bearer",
        "description": "an API key, where the service asks for one",
    },
    "apiKey": {"type": "apiKey", "in": "header", "name": "X-API-Key", "description": "the same, in a header"},
}


def _problem(**errors: Exception) -> dict[str, Any]:
    """One documented problem response with an example for each of its causes."""
    made = {name: problems.problem(error, "/requests/3f0c1f9e") for name, error in errors.items()}
    documents = {name: orjson.loads(problem.content) for name, problem in made.items()}
    content = {
        "schema": {"$ref": _REF.format(model="Problem")},
        "examples": {name: {"value": document} for name, document in documents.items()},
    }
    titles = dict.fromkeys(document["title"] for document in documents.values())
    return {"description": "; ".join(titles), "content": {problems.MEDIA_TYPE: content}}


def _json(name: str) -> Any:
    return orjson.loads((_EXAMPLES / name).read_bytes())


def _text(name: str) -> str:
    return (_EXAMPLES / name).read_text(encoding="utf-8")


def _capabilities() -> dict[str, Any]:
    """Those of a service with all settings at their defaults and nothing beside what it needs."""
    versions = Versions(**_json("answer.json")["receipt"]["versions"])
    made = capabilities(Settings.model_construct(), versions).model_dump()
    return made | {"extras": dict.fromkeys(made["extras"], False)}


def _header(description: str, example: str) -> dict[str, Any]:
    return {"description": description, "schema": {"type": "string"}, "example": example}


def _body() -> dict[str, Any]:
    """The request body of `fit` in all its media types."""
    csv = "x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in _json("request.json")["points"])
    content: dict[str, Any] = {
        "application/json": {
            "schema": {"$ref": _REF.format(model="FitRequest")},
            "examples": {"cylinder": {"value": _json("request.json")}},
        },
        "multipart/form-data": {
            "schema": {"$ref": _REF.format(model="FitUpload")},
            "examples": {"cylinder": {"value": {"file": csv, "options": {"kinds": ["cylinder", "cone"]}}}},
            "encoding": {"options": {"contentType": "application/json"}},
        },
    }
    for media_type in RAW_TYPES:
        content[media_type] = {"schema": {"type": "string", "format": "binary"}}
    for media_type in ("text/csv", "text/plain"):
        content[media_type]["examples"] = {"cylinder": {"value": csv}}
    return {"required": True, "content": content}


def _query() -> list[dict[str, Any]]:
    """The options again, as parameters of the query: any body may be sent with them.

    Without defaults, which generated clients would send along, and so give twice what stands in the body.
    """
    properties = FitOptions.model_json_schema(ref_template=_REF)["properties"]
    for name in OBJECTS:
        del properties[name]
    return [
        {"name": name, "in": "query", "required": False, "description": schema.pop("description")}
        | {"schema": _without_default(schema)}
        for name, schema in properties.items()
    ]


def _without_default(schema: dict[str, Any]) -> dict[str, Any]:
    chosen = next((option for option in schema.get("anyOf", []) if option != {"type": "null"}), schema)
    return {key: value for key, value in chosen.items() if key not in ("default", "title")}


_IF_NONE_MATCH: dict[str, Any] = {
    "name": "If-None-Match",
    "in": "header",
    "required": False,
    "description": "ETag of an answer that you have: 412 instead of a fit where it would be the same",
    "schema": {"type": "string"},
}
GET: dict[str, Any] = {
    "response_description": "It answers",
    "responses": {"500": _problem(internal=Exception())},
}
READYZ: dict[str, Any] = {
    "response_description": "It is ready",
    "responses": {
        "503": _problem(not_ready=_UNAVAILABLE["not_ready"]),
        "500": _problem(internal=Exception()),
    },
}
METRICS: dict[str, Any] = {
    "response_description": "The metrics",
    "responses": {
        "200": {"content": {"text/plain": {"examples": {"some": {"value": _text("metrics.txt")}}}}},
        "500": _problem(internal=Exception()),
    },
}
FIT: dict[str, Any] = {
    "response_description": "What was found",
    "responses": {
        "200": {"headers": {"ETag": _header("equal requests have equal tags", '"3f0c1f9e"')}},
        **{status: _problem(example=error) for status, error in _EXAMPLE_ERRORS.items()},
        "422": _problem(**_INVALID),
        "503": _problem(**_UNAVAILABLE),
    },
    "openapi_extra": {"requestBody": _body(), "parameters": [*_query(), _IF_NONE_MATCH]},
}


def document(app: FastAPI) -> dict[str, Any]:
    """The document of this application, made once."""
    if app.openapi_schema is None:
        app.openapi_schema = _make(app)
    return app.openapi_schema


def _at_the_door(path: str) -> dict[str, Any]:
    """What may come before a request is looked at: see `app.guard`."""
    refusals = {} if path in OPEN else {"401": _problem(example=_UNAUTHORIZED)}
    if path not in UNLIMITED:
        refusals["429"] = _problem(example=_LIMITED)
        refusals["429"]["headers"] = {"Retry-After": _header("seconds until the next one", "7")}
    return refusals


def _make(app: FastAPI) -> dict[str, Any]:
    made = get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
    modes = [(model, "validation") for model in (FitRequest, FitUpload, Problem)]
    _, definitions = models_json_schema(modes, ref_template=_REF)  # type: ignore[arg-type]
    made["components"]["schemas"] |= definitions["$defs"]
    made["components"]["securitySchemes"] = SECURITY_SCHEMES
    made["security"] = [{}, *({name: []} for name in SECURITY_SCHEMES)]
    for path, operations in made["paths"].items():
        for operation in operations.values():
            operation["responses"] |= _at_the_door(path)
    # Set here, because FastAPI would drop the nulls of an example.
    answers = made["paths"]["/fit"]["post"]["responses"]["200"]["content"]["application/json"]
    answers["examples"] = {"cylinder": {"value": _json("answer.json")}}
    answers = made["paths"]["/capabilities"]["get"]["responses"]["200"]["content"]["application/json"]
    answers["examples"] = {"defaults": {"value": _capabilities()}}
    return made
