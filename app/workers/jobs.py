"""What a worker process does with one request: read, fit, and write the body of the response."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from primfit.fitting.answer.result import Recognition
from primfit.fitting.names import ANSWER_PARTS, CRITERION

from ..engine.answer import answered_prepared, receipt, to_json, versions
from ..engine.fit import fit, prepared
from ..engine.names import base_name
from ..exports import Fitted, bundle, check_parts, check_unit
from ..readers import Cloud, Limits, Pick, UnreadableFileError, read, read_json, read_unpacked, unpack
from ..readers.columns import as_columns
from ..wire.artifacts import NAMES, split_query
from ..wire.disposition import attachment
from ..wire.etag import etag, names
from ..wire.multipart import split_parts
from ..wire.options import check_options, parse_options
from ..wire.problems import INTERNAL, MEDIA_TYPE, AlreadyAnsweredError, problem
from . import logs, memory
from .request_id import REQUEST_ID
from .trace_context import TRACE_ID
from .worker import WornOutError

ZIP = "application/zip"
_log = logging.getLogger("primfit")


class Job(Protocol):
    """What can be handed to a worker."""

    @property
    def request_id(self) -> str: ...

    @property
    def trace_id(self) -> str | None: ...

    def work(self) -> Any:
        """Do it; what is raised becomes a problem document."""


@dataclass(frozen=True)
class FitJob:
    """A request as the service received it; a large body stands in a file, `coding` is how it is packed."""

    request_id: str
    body: bytes | Path
    media_type: str
    content_type: str
    coding: str | None
    query: list[tuple[str, str]]
    limits: Limits
    if_none_match: str = ""
    export: bool = False
    trace_id: str | None = field(default_factory=TRACE_ID.get, kw_only=True)

    def work(self) -> "Reply":
        return _fit(self)


@dataclass(frozen=True)
class Reply:
    """A finished response, the seconds that went into its steps, and facts for the log and the metrics.

    The steps are `read`, `fit` and `encode`, in this order, or the `work` until the request was refused.
    """

    status: int
    content: bytes
    media_type: str = "application/json"
    headers: Mapping[str, str] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    facts: dict[str, Any] = field(default_factory=dict)


def warm(log_format: str, worker_memory: int) -> dict[str, str | None]:
    """Load the weights and fit once, so that no request waits for an import; returns the versions.

    From then on jobs may take `worker_memory` bytes.
    """
    logs.configure(log_format)
    grid = np.random.default_rng(0).uniform(-1.0, 1.0, (60, 3)) * [1.0, 1.0, 0.0]
    fit(grid)
    memory.allow(worker_memory)
    return versions("network")


def run(job: Job) -> Any:
    """What a job results in; every failure is a reply that holds a problem document.

    None where the request ended meanwhile: then there is nobody to tell.
    """
    REQUEST_ID.set(job.request_id)
    TRACE_ID.set(job.trace_id)
    started = perf_counter()
    try:
        return job.work()
    except FileNotFoundError:
        _log.info("request %s was given up, and its files are gone", job.request_id)
        return None
    except MemoryError:
        # What was half made may be held somewhere still.
        raise WornOutError(_refused(memory.too_large(), job, started)) from None
    except Exception as error:
        return _refused(error, job, started)


def _refused(error: Exception, job: Job, started: float) -> Reply:
    refused = problem(error, f"/requests/{job.request_id}")
    if refused.status == INTERNAL.status:
        _log.exception("the request failed")
    seconds, facts = {"work": perf_counter() - started}, {"problem": refused.slug}
    return Reply(refused.status, refused.content, MEDIA_TYPE, refused.headers, seconds, facts)


def _fit(job: FitJob) -> Reply:
    started = perf_counter()
    query, wanted = split_query(job.query) if job.export else (job.query, None)
    body: bytes | memoryview = job.body if isinstance(job.body, bytes) else job.body.read_bytes()
    if job.coding is not None:
        body = unpack(memoryview(body), job.coding, job.limits, "body")
    file, beside, name = _file(body, job)
    others = NAMES if job.export else ()
    options = check_options(query, beside, beside=others)
    cloud = _read(file, job, Pick(columns=as_columns(options.get("columns"))))
    if cloud.options:
        options = check_options(query, beside, cloud.options, beside=others)
    cloud = prepared(cloud, options)
    if wanted is not None:
        check_parts(wanted.formats, options.get("include", ANSWER_PARTS))
        check_unit(wanted.formats, cloud.unit)
    read_at = perf_counter()
    if job.if_none_match and wanted is None:
        tag = etag(receipt(cloud, options), cloud)
        if names(job.if_none_match, tag):
            raise AlreadyAnsweredError("the answer would be the one that you named", {"ETag": tag})
    recognition, content, facts = fitted(cloud, options, job.limits)
    fitted_at = perf_counter()
    if wanted is not None:
        media_type, headers = ZIP, {"Content-Disposition": attachment(_archive_name(name))}
        encoded = bundle(to_json(content), Fitted(recognition, cloud, options, name), wanted)
    else:
        media_type, headers = "application/json", {"ETag": etag(content["receipt"], cloud)}
        encoded = to_json(content)
    seconds = {"read": read_at - started, "fit": fitted_at - read_at, "encode": perf_counter() - fitted_at}
    return Reply(200, encoded, media_type, headers, seconds, facts)


def fitted(
    cloud: Cloud, options: Mapping[str, Any], limits: Limits
) -> tuple[Recognition, dict[str, Any], dict[str, Any]]:
    """What was recognized in a prepared cloud, the answer, and what the log and the metrics say of it.

    Raises `TooLargeError` before the fit where the criterion may not be done in time.
    """
    started = perf_counter()
    limits.check_criterion(len(cloud.points), options.get("criterion", CRITERION))
    recognition, content = answered_prepared(cloud, options)
    primitive = content["primitive"]
    return (
        recognition,
        content,
        {
            "fit_status": content["status"],
            "fit_kind": None if primitive is None else primitive["kind"],
            "n_points": content["receipt"]["n_points"],
            "attempts": len(content["attempts"]),
            "fit_seconds": round(perf_counter() - started, 4),
        },
    )


def _file(body: bytes | memoryview, job: FitJob) -> tuple[memoryview, Mapping[str, Any], str | None]:
    """What holds the cloud, the options that an upload has beside it, and the name of its file."""
    if job.media_type != "multipart/form-data":
        return memoryview(body), {}, None
    parts, name = split_parts(body, job.content_type)
    if "file" not in parts:
        raise UnreadableFileError("file", "part file is missing", "missing")
    beside = parse_options(parts["options"]) if "options" in parts else {}
    return memoryview(parts["file"]), beside, base_name(name)


def _read(file: memoryview, job: FitJob, pick: Pick) -> Cloud:
    if job.media_type == "application/json":
        return read_json(file, job.limits, pick)
    return (read_unpacked if job.coding else read)(file, job.limits, pick)


def _archive_name(name: str | None) -> str:
    """`scan.zip` for an upload of `scan.csv.gz`, `primfit.zip` where no name came with the cloud."""
    name = name or "primfit"
    if name.lower().endswith((".gz", ".zst")):
        name = name.rpartition(".")[0]
    return f"{name.rpartition('.')[0] or name}.zip"
