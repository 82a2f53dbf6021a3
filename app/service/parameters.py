"""What requests may carry beside their body, and answers beside theirs, as the OpenAPI document says it."""

from typing import Any

from ..exports import FORMATS as ARTIFACTS
from ..exports.options import ABOUT, LARGEST_ERROR, LONGEST, SMALLEST_ERROR
from ..wire.options import OBJECTS
from ..wire.schemas import BatchUpload, FitOptions

DEFAULT_PAGE, LARGEST_PAGE, LARGEST_OFFSET = 1000, 10_000, 10**9
"""Lines of the results of a job."""
REF = "#/components/schemas/{model}"
_REQUEST_ID = {"type": "string", "pattern": "^[A-Za-z0-9._-]{1,64}$"}
# What every operation takes and every answer carries, see `app.workers.request_id`.
PARAMETERS: dict[str, Any] = {
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
HEADERS: dict[str, Any] = {
    "RequestId": {
        "description": "id of the request, in the log and in the `instance` of a problem",
        "schema": _REQUEST_ID,
    },
    "RetryAfter": {"description": "seconds to wait before the next try", "schema": {"type": "integer"}},
    "PreferenceApplied": {
        "description": "the `wait` that was kept to, where one was asked for",
        "schema": {"type": "string"},
        "example": "wait=5",
    },
    "ServerTiming": {"description": "milliseconds of each step", "schema": {"type": "string"}},
}

# Each alone, or none at all: a service asks for keys only where it is told to.
SECURITY_SCHEMES = {
    "bearer": {
        "type": "http",
        "scheme": "bearer",
        "description": "an API key, where the service asks for one",
    },
    "apiKey": {"type": "apiKey", "in": "header", "name": "X-API-Key", "description": "the same, in a header"},
}

ARTIFACT_OPTIONS: list[dict[str, Any]] = [
    {
        "name": "artifacts",
        "in": "query",
        "required": True,
        "description": "files of the trimmed primitive, residuals of all points, form errors, a report",
        "schema": {"type": "array", "items": {"type": "string", "enum": list(ARTIFACTS)}},
        "style": "form",
        "explode": False,
        "example": ["glb", "csv", "report"],
    },
    {
        "name": "export_kind",
        "in": "query",
        "required": False,
        "description": "which kind of an ambiguous answer is exported; the first by default",
        "schema": {"$ref": REF.format(model="KindName")},
    },
    {
        "name": "chord_error",
        "in": "query",
        "required": False,
        "description": "largest distance of meshes from the surface over their size; 0.001 by default",
        "schema": {"type": "number", "minimum": SMALLEST_ERROR, "maximum": LARGEST_ERROR},
    },
    *(
        {
            "name": name,
            "in": "query",
            "required": False,
            "description": f"{name} on the report, as given; it has none by default",
            "schema": {"type": "string", "maxLength": LONGEST},
        }
        for name in ABOUT
    ),
]


def _optional(name: str, place: str, description: str | None, **schema: Any) -> dict[str, Any]:
    """A parameter that may be left out: a string where its schema says nothing else."""
    return {
        "name": name,
        "in": place,
        "required": False,
        "description": description,
        "schema": {"type": "string"} | schema,
    }


IF_NONE_MATCH = _optional(
    "If-None-Match",
    "header",
    "ETag of an answer that you have: 412 instead of a fit where it would be the same",
)
PREFER = _optional(
    "Prefer",
    "header",
    "`wait=5`: refuse or stop what is not answered within 5 seconds of the body; at most the "
    "`fit_time_limit` of the service, which holds by default",
)
RESPOND_ASYNC = _optional("Prefer", "header", "`respond-async` makes it a job, where the service keeps some")
LABELS = _optional("labels", "query", BatchUpload.model_fields["labels"].description)
IDEMPOTENCY_KEY = _optional(
    "Idempotency-Key",
    "header",
    "a key of your own for a job: to ask again with it brings the same job, not another one",
    maxLength=255,
)
OFFSET = _optional(
    "offset", "query", "the first line, 0 by default", type="integer", minimum=0, maximum=LARGEST_OFFSET
)
LIMIT = _optional(
    "limit",
    "query",
    f"the most lines, {DEFAULT_PAGE} by default",
    type="integer",
    minimum=1,
    maximum=LARGEST_PAGE,
)
LAST_EVENT_ID = _optional(
    "Last-Event-ID",
    "header",
    "id of the last event that came: the number of a line, or `end`",
    pattern="^([0-9]{1,18}|end)?$",
)
JOB_ID: dict[str, Any] = {
    "name": "job_id",
    "in": "path",
    "required": True,
    "description": "`jobID` of the job",
    "schema": {"type": "string"},
}


def options_in_query() -> list[dict[str, Any]]:
    """The options again, as parameters of the query: any body may be sent with them.

    Without defaults, which generated clients would send along, and so give twice what stands in the body.
    """
    properties = FitOptions.model_json_schema(ref_template=REF)["properties"]
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
