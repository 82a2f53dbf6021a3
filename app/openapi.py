"""The OpenAPI document: what FastAPI cannot read off the routes, with real examples."""

from pathlib import Path
from typing import Any

import orjson
from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic.json_schema import models_json_schema

from app import problems
from app.exports import FORMATS, NothingToExportError
from app.exports.options import LARGEST_ERROR, SMALLEST_ERROR, UNITS
from app.options import OBJECTS
from app.readers.errors import FieldError, InvalidPointsError, TooLargeError, UnreadableFileError
from app.schemas import FitOptions, FitRequest, FitUpload, Problem

DESCRIPTION = (
    "Which geometric primitive is a segmented 3D point cloud - plane, sphere, cylinder, cone or torus - "
    "and with which parameters? Send a cloud to `POST /fit`."
)
RAW_TYPES = (
    "application/octet-stream",
    "text/csv",
    "text/plain",
    "text/tab-separated-values",
    "application/x-npy",
    "model/ply",
    "application/ply",
)
MEDIA_TYPES = ("application/json", "multipart/form-data", *RAW_TYPES)
WHAT_IS_READ = f"send one of {', '.join(MEDIA_TYPES)}, without content encoding"

_EXAMPLES = Path(__file__).with_name("examples")
_REF = "#/components/schemas/{model}"
_EXAMPLE_ERRORS: dict[str, Exception] = {
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
    "artifacts": NothingToExportError("the answer is no_fit and holds no primitive to export"),
}
_UNAVAILABLE: dict[str, Exception] = {
    "not_ready": problems.NotReadyError("no worker is warm yet"),
    "busy": problems.BusyError("64 requests are waiting, the limit of this service"),
    "worker_died": problems.WorkerDiedError("the worker process ended while it worked on this request"),
}


_ARTIFACTS: list[dict[str, Any]] = [
    {
        "name": "artifacts",
        "in": "query",
        "required": False,
        "description": "files of the trimmed primitive: the response is a ZIP of answer.json and them",
        "schema": {"type": "array", "items": {"type": "string", "enum": list(FORMATS)}},
        "style": "form",
        "explode": False,
    },
    {
        "name": "unit",
        "in": "query",
        "required": False,
        "description": "of the coordinates, as STEP files say it; beside `artifacts` only, mm by default",
        "schema": {"type": "string", "enum": list(UNITS)},
    },
    {
        "name": "chord_error",
        "in": "query",
        "required": False,
        "description": "largest distance of meshes from the surface, as a share of the size; beside "
        "`artifacts` only, 0.001 by default",
        "schema": {"type": "number", "minimum": SMALLEST_ERROR, "maximum": LARGEST_ERROR},
    },
]


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
    options = [
        {"name": name, "in": "query", "required": False, "description": schema.pop("description")}
        | {"schema": _without_default(schema)}
        for name, schema in properties.items()
    ]
    return options + _ARTIFACTS


def _without_default(schema: dict[str, Any]) -> dict[str, Any]:
    chosen = next((option for option in schema.get("anyOf", []) if option != {"type": "null"}), schema)
    return {key: value for key, value in chosen.items() if key not in ("default", "title")}


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
FIT: dict[str, Any] = {
    "response_description": "What was found",
    "responses": {
        "200": {"content": {"application/zip": {"schema": {"type": "string", "format": "binary"}}}},
        **{status: _problem(example=error) for status, error in _EXAMPLE_ERRORS.items()},
        "422": _problem(**_INVALID),
        "503": _problem(**_UNAVAILABLE),
    },
    "openapi_extra": {"requestBody": _body(), "parameters": _query()},
}


def document(app: FastAPI) -> dict[str, Any]:
    """The document of this application, made once."""
    if app.openapi_schema is None:
        app.openapi_schema = _make(app)
    return app.openapi_schema


def _make(app: FastAPI) -> dict[str, Any]:
    made = get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
    modes = [(model, "validation") for model in (FitRequest, FitUpload, Problem)]
    _, definitions = models_json_schema(modes, ref_template=_REF)  # type: ignore[arg-type]
    made["components"]["schemas"] |= definitions["$defs"]
    # Set here, because FastAPI would drop the nulls of an example.
    answers = made["paths"]["/fit"]["post"]["responses"]["200"]["content"]["application/json"]
    answers["examples"] = {"cylinder": {"value": _json("answer.json")}}
    return made
