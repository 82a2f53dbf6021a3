"""The OpenAPI document: what FastAPI reads off the routes, and what it cannot."""

from typing import Any

import orjson
from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic.json_schema import models_json_schema

from ..wire.schemas import (
    BatchAnswer,
    BatchProblem,
    BatchSummary,
    BatchUpload,
    FitRequest,
    FitUpload,
    Problem,
    Versions,
)
from .capabilities import capabilities
from .guard import OPEN, UNLIMITED
from .media_types import NDJSON
from .operations import example, refused
from .parameters import HEADERS, PARAMETERS, REF, SECURITY_SCHEMES
from .settings import Settings

DESCRIPTION = (
    "Which geometric primitive is a segmented 3D point cloud - plane, sphere, cylinder, cone or torus - "
    "and with which parameters? Send a cloud to `POST /fit`."
)
TAGS = (
    {"name": "fitting", "description": "Clouds in, primitives out."},
    {"name": "jobs", "description": "Many clouds, handed in now and asked for later."},
    {"name": "service", "description": "How the service is, and what it is."},
)
_BATCH_LINES = (BatchAnswer, BatchProblem, BatchSummary)


def document(app: FastAPI) -> dict[str, Any]:
    """The document of this application, made once."""
    if app.openapi_schema is None:
        app.openapi_schema = _make(app)
    return app.openapi_schema


def as_text(app: FastAPI) -> bytes:
    """The document as a file to read and to compare: indented, schemas by name."""
    return orjson.dumps(document(app), option=orjson.OPT_INDENT_2 | orjson.OPT_APPEND_NEWLINE)


def _make(app: FastAPI) -> dict[str, Any]:
    made = get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
    components = made["components"]
    components["schemas"] = dict(sorted((components["schemas"] | _schemas()).items()))
    components["securitySchemes"] = SECURITY_SCHEMES
    made["security"] = [{}, *({name: []} for name in SECURITY_SCHEMES)]
    for path, method in (("/fit/batch", "post"), ("/jobs/{job_id}/results", "get")):
        made["paths"][path][method]["responses"]["200"]["content"] = {NDJSON: _lines()}
    # Set here, because FastAPI would drop the nulls of an example.
    _in_json(made, "/fit", "post")["examples"] = {"cylinder": {"value": example("answer.json")}}
    _in_json(made, "/capabilities", "get")["examples"] = {"defaults": {"value": _capabilities()}}
    for path, operations in made["paths"].items():
        for operation in operations.values():
            for status, refusal in _at_the_door(path).items():
                operation["responses"].setdefault(status, refusal)
    _add_headers(made)
    return made | {"tags": list(TAGS)}


def _schemas() -> dict[str, Any]:
    """Those of the models that no route names."""
    models = (FitRequest, FitUpload, BatchUpload, *_BATCH_LINES, Problem)
    modes = [(model, "validation") for model in models]
    _, definitions = models_json_schema(modes, ref_template=REF)  # type: ignore[arg-type]
    lines = [{"$ref": REF.format(model=model.__name__)} for model in _BATCH_LINES]
    return {**definitions["$defs"], "BatchLine": {"title": "BatchLine", "oneOf": lines}}


def _lines() -> dict[str, Any]:
    """A line of a batch, with an example of each sort."""
    lines = example("lines.json")
    lines["answer"] |= {"answer": example("answer.json")}
    examples = {name: {"value": line} for name, line in lines.items()}
    return {"schema": {"$ref": REF.format(model="BatchLine")}, "examples": examples}


def _in_json(made: dict[str, Any], path: str, method: str) -> Any:
    """The answer of an operation."""
    return made["paths"][path][method]["responses"]["200"]["content"]["application/json"]


def _capabilities() -> dict[str, Any]:
    """Those of a service with all settings at their defaults and nothing beside what it needs."""
    versions = Versions(**example("answer.json")["receipt"]["versions"])
    made = capabilities(Settings.model_construct(), versions).model_dump()
    return made | {"extras": dict.fromkeys(made["extras"], False)}


def _at_the_door(path: str) -> dict[str, Any]:
    """What may come before a request is looked at: see `app.service.guard`."""
    refusals = {} if path in OPEN else {"401": refused("401")}
    if path not in UNLIMITED:
        refusals["429"] = refused("429", "example")
    return refusals


def _add_headers(made: dict[str, Any]) -> None:
    """What every operation takes and every answer carries."""
    made["components"] |= {"parameters": PARAMETERS, "headers": HEADERS}
    for operation in (operation for path in made["paths"].values() for operation in path.values()):
        operation.setdefault("parameters", []).append({"$ref": "#/components/parameters/RequestId"})
        for status, response in operation["responses"].items():
            headers = response.setdefault("headers", {})
            headers["X-Request-Id"] = {"$ref": "#/components/headers/RequestId"}
            if status in ("429", "503"):
                headers["Retry-After"] = {"$ref": "#/components/headers/RetryAfter"}
