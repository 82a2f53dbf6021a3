"""What FastAPI cannot read off the routes, an operation each: bodies, parameters, refusals, examples."""

from pathlib import Path
from typing import Any

import orjson

from ..wire.problems import MEDIA_TYPE
from .media_types import RAW_TYPES
from .parameters import (
    ARTIFACT_OPTIONS,
    IDEMPOTENCY_KEY,
    IF_NONE_MATCH,
    JOB_ID,
    LABELS,
    LAST_EVENT_ID,
    LIMIT,
    OFFSET,
    PREFER,
    REF,
    RESPOND_ASYNC,
    options_in_query,
)

_EXAMPLES = Path(__file__).parents[1] / "examples"


def text(name: str) -> str:
    """An example as it stands in its file."""
    return (_EXAMPLES / name).read_text(encoding="utf-8")


def example(name: str) -> Any:
    """An example in JSON."""
    return orjson.loads(text(name))


_PROBLEMS: dict[str, dict[str, Any]] = example("problems.json")


def refused(status: str, *names: str) -> dict[str, Any]:
    """The problem response of a status, with examples of these causes; of all that there are by default."""
    shown = {name: _PROBLEMS[status][name] for name in names or _PROBLEMS[status]}
    content = {
        "schema": {"$ref": REF.format(model="Problem")},
        "examples": {name: {"value": document} for name, document in shown.items()},
    }
    titles = dict.fromkeys(document["title"] for document in shown.values())
    return {"description": "; ".join(titles), "content": {MEDIA_TYPE: content}}


def _shown(**values: Any) -> dict[str, Any]:
    return {name: {"value": value} for name, value in values.items()}


def _body(upload: str, uploaded: dict[str, Any]) -> dict[str, Any]:
    """A request body in all its media types; `upload` is the model of the one in parts, with an example."""
    content: dict[str, Any] = {
        "application/json": {
            "schema": {"$ref": REF.format(model="FitRequest")},
            "examples": _shown(
                cylinder=example("request.json"), cylinder_in_base64=example("request_base64.json")
            ),
        },
        "multipart/form-data": {
            "schema": {"$ref": REF.format(model=upload)},
            "examples": _shown(cylinder=uploaded),
            "encoding": {"options": {"contentType": "application/json"}},
        },
    }
    for media_type in RAW_TYPES:
        content[media_type] = {"schema": {"type": "string", "format": "binary"}}
    for media_type, name in _FILES.items():
        content[media_type]["examples"] = _shown(cylinder=text(name))
    return {"required": True, "description": _BODY, "content": content}


_BODY = (
    "The cloud. A body may be packed (`Content-Encoding: gzip` or `zstd`), and so may a file; "
    "files are recognized by what they hold, whatever their media type"
)
_FILES = {
    **dict.fromkeys(("application/octet-stream", "text/csv", "text/plain"), "few.csv"),
    "text/tab-separated-values": "few.tsv",
    **dict.fromkeys(("model/ply", "application/ply"), "few.ply"),
}
_OPTIONS = {"kinds": ["cylinder", "cone"]}
_EVENT = "event: status\nid: end\ndata: {...}\n\n"
_TOLD = {
    "Server-Timing": {"$ref": "#/components/headers/ServerTiming"},
    "Preference-Applied": {"$ref": "#/components/headers/PreferenceApplied"},
}
_FILE_NAME = {
    "description": "a name for the file, after that of the uploaded one",
    "schema": {"type": "string"},
    "example": 'attachment; filename="cylinder.zip"',
}
_ETAG = {
    "description": "equal requests have equal tags",
    "schema": {"type": "string"},
    "example": '"3f0c1f9e"',
}
GET: dict[str, Any] = {
    "tags": ["service"],
    "response_description": "It answers",
    "responses": {"500": refused("500", "internal")},
}
READYZ: dict[str, Any] = {
    "tags": ["service"],
    "response_description": "It is ready",
    "responses": {
        "503": refused("503", "not_ready"),
        "500": refused("500", "internal"),
    },
}
METRICS: dict[str, Any] = {
    "tags": ["service"],
    "response_description": "The metrics",
    "responses": {
        "200": {"content": {"text/plain": {"examples": _shown(some=text("metrics.txt"))}}},
        "500": refused("500", "internal"),
    },
}
FIT: dict[str, Any] = {
    "tags": ["fitting"],
    "response_description": "What was found",
    "responses": {
        "200": {
            "headers": {"ETag": _ETAG, **_TOLD},
        },
        **{status: refused(status, "example") for status in ("412", "408", "413", "500", "504", "507")},
        "415": refused("415"),
        "422": refused("422", "points", "file", "options"),
        "503": refused("503", "not_ready", "busy", "worker_died", "stopping"),
    },
    "openapi_extra": {
        "requestBody": _body("FitUpload", {"file": text("few.csv"), "options": _OPTIONS}),
        "parameters": [*options_in_query(), IF_NONE_MATCH, PREFER],
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
            "headers": {"Content-Disposition": _FILE_NAME, **_TOLD},
            "content": {"application/zip": {"schema": {"type": "string", "format": "binary"}}},
        },
        "422": refused("422", "points", "file", "options", "artifacts"),
    },
    "openapi_extra": {
        "requestBody": FIT["openapi_extra"]["requestBody"],
        "parameters": [*ARTIFACT_OPTIONS, *options_in_query(), PREFER],
    },
}
JOBS: dict[str, Any] = example("jobs.json")
_LOCATION = {
    "description": "where the status of the job is, relative to the path of the request",
    "schema": {"type": "string"},
    "example": "jobs/0b2b7d8e-7f6c-4f0e-9d6a-3c1f5a1e2d4b",
}
_BATCH_BODY = _body("BatchUpload", {"file": [text("few.csv")] * 2, "options": _OPTIONS})
FIT_BATCH: dict[str, Any] = {
    "tags": ["fitting"],
    "status_code": 200,
    "responses": {
        **_REFUSALS,
        "200": {
            "description": "A JSON object a line: for each item, in the order of the input, what was found "
            "or the problem with it; then the summary",
        },
        "202": {
            "description": "With `Prefer: respond-async`: it is kept as a job, as by `POST /jobs`",
            "headers": {"Location": _LOCATION},
            "content": {
                "application/json": {
                    "schema": {"$ref": REF.format(model="JobStatus")},
                    "examples": _shown(accepted=JOBS["accepted"]),
                }
            },
        },
    },
    "openapi_extra": {
        "requestBody": _BATCH_BODY,
        "parameters": [RESPOND_ASYNC, IDEMPOTENCY_KEY, LABELS, *options_in_query()],
    },
}
_OF_ONE_JOB = {
    "404": refused("404", "no_such_job", "jobs_off"),
    "500": refused("500", "internal"),
    "503": refused("503", "jobs_unavailable"),
}
SUBMIT_JOB: dict[str, Any] = {
    "tags": ["jobs"],
    "response_description": "It is kept, and will be done",
    "responses": {
        **_REFUSALS,
        "202": {
            "headers": {"Location": _LOCATION},
            "content": {"application/json": {"examples": _shown(accepted=JOBS["accepted"])}},
        },
        "404": refused("404", "jobs_off"),
        "422": refused("422", "file", "options", "idempotency_key_reused"),
        "429": refused("429", "example", "too_many_jobs"),
        "503": refused("503", "busy", "jobs_unavailable"),
        "507": refused("507"),
    },
    "openapi_extra": {
        "requestBody": _BATCH_BODY,
        "parameters": [IDEMPOTENCY_KEY, LABELS, *options_in_query()],
    },
}
LIST_JOBS: dict[str, Any] = {
    "tags": ["jobs"],
    "response_description": "The jobs, in the order in which they came",
    "responses": {
        "200": {
            "content": {
                "application/json": {"examples": _shown(one={"jobs": [JOBS["accepted"]], "links": []})}
            }
        },
        **_OF_ONE_JOB,
        "404": refused("404", "jobs_off"),
    },
}
JOB_STATUS: dict[str, Any] = {
    "tags": ["jobs"],
    "response_description": "Its status",
    "responses": {
        "200": {"content": {"application/json": {"examples": _shown(successful=JOBS["successful"])}}},
        **_OF_ONE_JOB,
    },
    "openapi_extra": {"parameters": [JOB_ID]},
}
JOB_RESULTS: dict[str, Any] = {
    "tags": ["jobs"],
    "status_code": 200,
    "response_description": "The lines, byte for byte those of `POST /fit/batch`",
    "responses": {
        "200": {
            "headers": {
                "Link": {
                    "description": "where the next lines are",
                    "schema": {"type": "string"},
                    "example": '<?offset=1000&limit=1000>; rel="next"',
                }
            }
        },
        **_OF_ONE_JOB,
        "422": refused("422", "options"),
    },
    "openapi_extra": {"parameters": [JOB_ID, OFFSET, LIMIT]},
}
JOB_EVENTS: dict[str, Any] = {
    "tags": ["jobs"],
    "status_code": 200,
    "response_description": "The events",
    "responses": {
        "200": {
            "content": {"text/event-stream": {"schema": {"type": "string"}, "examples": _shown(end=_EVENT)}}
        },
        "204": {"description": "Nothing is left to tell"},
        **_OF_ONE_JOB,
        "422": refused("422", "options"),
    },
    "openapi_extra": {"parameters": [JOB_ID, LAST_EVENT_ID]},
}
DISMISS_JOB: dict[str, Any] = {**JOB_STATUS, "response_description": "Its last status"}
