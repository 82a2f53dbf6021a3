"""The OpenAPI document: what FastAPI cannot read off the routes, with real examples."""

from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np
import orjson
from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic.json_schema import models_json_schema

from primfit.fitting.errors import InvalidPointCloudError

from ..exports import FORMATS as ARTIFACTS
from ..exports import NothingToExportError
from ..exports.options import LARGEST_ERROR, SMALLEST_ERROR, UNITS
from ..readers import CODINGS, FORMATS
from ..readers.errors import FieldError, InvalidPointsError, TooLargeError, UnreadableFileError
from ..wire import problems
from ..wire.options import OBJECTS
from ..wire.schemas import (
    BatchAnswer,
    BatchProblem,
    BatchSummary,
    BatchUpload,
    FitOptions,
    FitRequest,
    FitUpload,
    Problem,
    Versions,
)
from .capabilities import capabilities
from .guard import OPEN, UNLIMITED
from .settings import Settings

DESCRIPTION = (
    "Which geometric primitive is a segmented 3D point cloud - plane, sphere, cylinder, cone or torus - "
    "and with which parameters? Send a cloud to `POST /fit`."
)
RAW_TYPES = (
    "application/octet-stream",
    *(media_type for format in FORMATS if format.name != "json" for media_type in format.media_types),
    *(f"application/{coding}" for coding in CODINGS),
)
NDJSON = "application/x-ndjson"
MEDIA_TYPES = ("application/json", "multipart/form-data", *RAW_TYPES)
WHAT_IS_READ = f"send one of {', '.join(MEDIA_TYPES)}"

TAGS = (
    {"name": "fitting", "description": "Clouds in, primitives out."},
    {"name": "service", "description": "How the service is, and what it is."},
)
_REQUEST_ID = {"type": "string", "pattern": "^[A-Za-z0-9._-]{1,64}$"}
# What every operation takes and every answer carries, see `app.service.request_id`.
_PARAMETERS: dict[str, Any] = {
    "RequestId": {
        "name": "X-Request-Id",
        "in": "header",
        "required": False,
        "description": "an id of your own for this request, up to 64 of A-Z a-z 0-9 . _ -; "
        "in place of any other the service makes one up",
        "schema": {"type": "string"},
        "example": "3f0c1f9e",
    }
}
_HEADERS: dict[str, Any] = {
    "RequestId": {
        "description": "id of the request, in the log and in the `instance` of a problem",
        "schema": _REQUEST_ID,
    },
    "RetryAfter": {"description": "seconds to wait before the next try", "schema": {"type": "integer"}},
    "ServerTiming": {"description": "milliseconds of each step", "schema": {"type": "string"}},
}

_EXAMPLES = Path(__file__).parents[1] / "examples"
_REF = "#/components/schemas/{model}"
_EXAMPLE_ERRORS: dict[str, Exception] = {
    "412": problems.AlreadyAnsweredError("the answer would be the one that you named", {}),
    "408": problems.BodyTimeoutError("nothing came for 30 s before the body was complete (1048576 bytes)"),
    "413": TooLargeError("body", "the body is over 67108864 bytes, the limit of this service"),
    "500": Exception(),
    "504": problems.TimeLimitError("not done after 60 s, the limit of this service; the work was stopped"),
}
_UNSUPPORTED: dict[str, Exception] = {
    "media_type": problems.UnsupportedMediaTypeError(WHAT_IS_READ),
    "content_encoding": problems.UnsupportedCodingError(
        "send the body as it is, or in one of gzip, zstd, once"
    ),
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
_NOTHING_TO_EXPORT = NothingToExportError("the answer is no_fit and holds no primitive to export")
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


_ARTIFACTS: list[dict[str, Any]] = [
    {
        "name": "artifacts",
        "in": "query",
        "required": True,
        "description": "files of the trimmed primitive, residuals of all points, form errors, a report",
        "schema": {"type": "array", "items": {"type": "string", "enum": list(ARTIFACTS)}},
        "style": "form",
        "explode": False,
        "example": ["step", "glb", "report"],
    },
    {
        "name": "unit",
        "in": "query",
        "required": False,
        "description": "of the coordinates, as STEP files and reports say it; mm by default",
        "schema": {"type": "string", "enum": list(UNITS)},
    },
    {
        "name": "chord_error",
        "in": "query",
        "required": False,
        "description": "largest distance of meshes from the surface over their size; 0.001 by default",
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


def _text(name: str) -> str:
    return (_EXAMPLES / name).read_text(encoding="utf-8")


def _capabilities() -> dict[str, Any]:
    """Those of a service with all settings at their defaults and nothing beside what it needs."""
    versions = Versions(**_json("answer.json")["receipt"]["versions"])
    made = capabilities(Settings.model_construct(), versions).model_dump()
    return made | {"extras": dict.fromkeys(made["extras"], False)}


def _header(description: str, example: str) -> dict[str, Any]:
    return {"description": description, "schema": {"type": "string"}, "example": example}


def _encoded(request: dict[str, Any]) -> dict[str, Any]:
    """The same request with its points as a base64 array."""
    points = np.array(request["points"], "<f8")
    array = {"dtype": "float64", "shape": list(points.shape), "base64": b64encode(points.tobytes()).decode()}
    return {**request, "points": array}


def _csv() -> str:
    return "x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in _json("request.json")["points"])


def _body(upload: str, uploaded: dict[str, Any]) -> dict[str, Any]:
    """A request body in all its media types; `upload` is the model of the one in parts, with an example."""
    points, csv = _json("request.json")["points"], _csv()
    ply = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n" + "".join(
        f"property double {name}\n" for name in "xyz"
    )
    ply += "end_header\n" + "".join(f"{x} {y} {z}\n" for x, y, z in points)
    as_text = dict.fromkeys(("application/octet-stream", "text/csv", "text/plain"), csv)
    as_text |= {"text/tab-separated-values": csv.replace(",", "\t"), "model/ply": ply, "application/ply": ply}
    content: dict[str, Any] = {
        "application/json": {
            "schema": {"$ref": _REF.format(model="FitRequest")},
            "examples": {
                "cylinder": {"value": _json("request.json")},
                "cylinder_in_base64": {"value": _encoded(_json("request.json"))},
            },
        },
        "multipart/form-data": {
            "schema": {"$ref": _REF.format(model=upload)},
            "examples": {"cylinder": {"value": uploaded}},
            "encoding": {"options": {"contentType": "application/json"}},
        },
    }
    for media_type in RAW_TYPES:
        content[media_type] = {"schema": {"type": "string", "format": "binary"}}
    for media_type, text in as_text.items():
        content[media_type]["examples"] = {"cylinder": {"value": text}}
    description = (
        "The cloud. A body may be packed (`Content-Encoding: gzip` or `zstd`), and so may a file; "
        "files are recognised by what they hold, whatever their media type"
    )
    return {"required": True, "description": description, "content": content}


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
    "tags": ["service"],
    "response_description": "It answers",
    "responses": {"500": _problem(internal=Exception())},
}
READYZ: dict[str, Any] = {
    "tags": ["service"],
    "response_description": "It is ready",
    "responses": {
        "503": _problem(not_ready=_UNAVAILABLE["not_ready"]),
        "500": _problem(internal=Exception()),
    },
}
METRICS: dict[str, Any] = {
    "tags": ["service"],
    "response_description": "The metrics",
    "responses": {
        "200": {"content": {"text/plain": {"examples": {"some": {"value": _text("metrics.txt")}}}}},
        "500": _problem(internal=Exception()),
    },
}
FIT: dict[str, Any] = {
    "tags": ["fitting"],
    "response_description": "What was found",
    "responses": {
        "200": {
            "headers": {
                "ETag": _header("equal requests have equal tags", '"3f0c1f9e"'),
                "Server-Timing": {"$ref": "#/components/headers/ServerTiming"},
            },
        },
        **{status: _problem(example=error) for status, error in _EXAMPLE_ERRORS.items()},
        "415": _problem(**_UNSUPPORTED),
        "422": _problem(**_INVALID),
        "503": _problem(**_UNAVAILABLE),
    },
    "openapi_extra": {
        "requestBody": _body("FitUpload", {"file": _csv(), "options": {"kinds": ["cylinder", "cone"]}}),
        "parameters": [*_query(), _IF_NONE_MATCH],
    },
}
# Only `fit` has tags to compare.
_REFUSALS = {status: refused for status, refused in FIT["responses"].items() if status not in ("200", "412")}
FIT_EXPORT: dict[str, Any] = {
    "tags": ["fitting"],
    "response_description": "`answer.json`, the answer of `POST /fit`, and the files",
    "responses": {
        **_REFUSALS,
        "200": {
            "headers": {"Server-Timing": {"$ref": "#/components/headers/ServerTiming"}},
            "content": {"application/zip": {"schema": {"type": "string", "format": "binary"}}},
        },
        "422": _problem(**_INVALID, artifacts=_NOTHING_TO_EXPORT),
    },
    "openapi_extra": {
        "requestBody": FIT["openapi_extra"]["requestBody"],
        "parameters": [*_ARTIFACTS, *_query()],
    },
}


def _lines() -> dict[str, Any]:
    """A line of a batch, with an example of each sort."""
    few = problems.problem(
        InvalidPointCloudError("2 points given; at least 3 are needed"), "/requests/3f0c1f9e"
    )
    item = {"id": "scan.csv#1", "file": "scan.csv", "label": 1}
    values = {
        "answer": {**item, "answer": _json("answer.json")},
        "problem": {**item, "id": "scan.csv#2", "label": 2, "problem": orjson.loads(few.content)},
        "summary": {"summary": {"items": 2, "fitted": 1, "ambiguous": 0, "no_fit": 0, "problems": 1}},
    }
    examples = {name: {"value": value} for name, value in values.items()}
    return {"schema": {"$ref": _REF.format(model="BatchLine")}, "examples": examples}


_BATCH_LINES = (BatchAnswer, BatchProblem, BatchSummary)
_LABELS = BatchUpload.model_fields["labels"].description
FIT_BATCH: dict[str, Any] = {
    "tags": ["fitting"],
    "status_code": 200,
    "responses": {
        **_REFUSALS,
        "200": {
            "description": "A JSON object a line: for each item, in the order of the input, what was found "
            "or the problem with it; then the summary",
        },
    },
    "openapi_extra": {
        "requestBody": _body(
            "BatchUpload", {"file": [_csv(), _csv()], "options": {"kinds": ["cylinder", "cone"]}}
        ),
        "parameters": [
            {"name": "labels", "in": "query", "required": False, "description": _LABELS}
            | {"schema": {"type": "string"}},
            *_query(),
        ],
    },
}


def document(app: FastAPI) -> dict[str, Any]:
    """The document of this application, made once."""
    if app.openapi_schema is None:
        app.openapi_schema = _make(app)
    return app.openapi_schema


def _at_the_door(path: str) -> dict[str, Any]:
    """What may come before a request is looked at: see `app.service.guard`."""
    refusals = {} if path in OPEN else {"401": _problem(example=_UNAUTHORIZED)}
    if path not in UNLIMITED:
        refusals["429"] = _problem(example=_LIMITED)
    return refusals


def as_text(app: FastAPI) -> bytes:
    """The document as a file to read and to compare: indented, schemas by name."""
    return orjson.dumps(document(app), option=orjson.OPT_INDENT_2 | orjson.OPT_APPEND_NEWLINE)


def _make(app: FastAPI) -> dict[str, Any]:
    made = get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
    models = (FitRequest, FitUpload, BatchUpload, *_BATCH_LINES, Problem)
    modes = [(model, "validation") for model in models]
    _, definitions = models_json_schema(modes, ref_template=_REF)  # type: ignore[arg-type]
    lines = [{"$ref": _REF.format(model=model.__name__)} for model in _BATCH_LINES]
    definitions["$defs"]["BatchLine"] = {"title": "BatchLine", "oneOf": lines}
    schemas = made["components"]["schemas"] | definitions["$defs"]
    made["components"]["schemas"] = dict(sorted(schemas.items()))
    made["components"]["securitySchemes"] = SECURITY_SCHEMES
    made["security"] = [{}, *({name: []} for name in SECURITY_SCHEMES)]
    made["paths"]["/fit/batch"]["post"]["responses"]["200"]["content"] = {NDJSON: _lines()}
    # Set here, because FastAPI would drop the nulls of an example.
    answers = made["paths"]["/fit"]["post"]["responses"]["200"]["content"]["application/json"]
    answers["examples"] = {"cylinder": {"value": _json("answer.json")}}
    answers = made["paths"]["/capabilities"]["get"]["responses"]["200"]["content"]["application/json"]
    answers["examples"] = {"defaults": {"value": _capabilities()}}
    for path, operations in made["paths"].items():
        for operation in operations.values():
            operation["responses"] |= _at_the_door(path)
    _add_headers(made)
    return made | {"tags": list(TAGS)}


def _add_headers(made: dict[str, Any]) -> None:
    """What every operation takes and every answer carries."""
    made["components"] |= {"parameters": _PARAMETERS, "headers": _HEADERS}
    for operation in (operation for path in made["paths"].values() for operation in path.values()):
        operation.setdefault("parameters", []).append({"$ref": "#/components/parameters/RequestId"})
        for status, response in operation["responses"].items():
            headers = response.setdefault("headers", {})
            headers["X-Request-Id"] = {"$ref": "#/components/headers/RequestId"}
            if status in ("429", "503"):
                headers["Retry-After"] = {"$ref": "#/components/headers/RetryAfter"}
