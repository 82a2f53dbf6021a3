"""What a worker process does with one request: read, fit, and write the body of the response."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from app import logs
from app.answer import answer, receipt, to_json, versions
from app.engine import fit, fit_cloud
from app.etag import etag, names
from app.multipart import split_parts
from app.options import check_options, parse_options
from app.problems import MEDIA_TYPE, AlreadyAnsweredError, problem
from app.readers import Cloud, Limits, UnreadableFileError, read, read_json
from app.request_id import REQUEST_ID

_log = logging.getLogger("primfit")


@dataclass(frozen=True)
class FitJob:
    """A request as the service received it; a large body stands in a file."""

    request_id: str
    body: bytes | Path
    media_type: str
    content_type: str
    query: list[tuple[str, str]]
    limits: Limits
    if_none_match: str = ""


@dataclass(frozen=True)
class Reply:
    """A finished response, the seconds that went into its steps, and facts for the log and the metrics."""

    status: int
    content: bytes
    media_type: str = "application/json"
    headers: Mapping[str, str] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    facts: dict[str, Any] = field(default_factory=dict)


def warm(log_format: str) -> dict[str, str | None]:
    """Load the weights and fit once, so that no request waits for an import; returns the versions."""
    logs.configure(log_format)
    grid = np.random.default_rng(0).uniform(-1.0, 1.0, (60, 3)) * [1.0, 1.0, 0.0]
    fit(grid)
    return versions("network")


def run(job: FitJob) -> Reply:
    """The response to one request; every failure is a problem document."""
    REQUEST_ID.set(job.request_id)
    try:
        return _fit(job)
    except Exception as error:
        refused = problem(error, f"/requests/{job.request_id}")
        if refused.status >= 500:
            _log.exception("the request failed")
        facts = {"problem": refused.slug}
        return Reply(refused.status, refused.content, MEDIA_TYPE, refused.headers, facts=facts)


def _fit(job: FitJob) -> Reply:
    started = perf_counter()
    body = job.body if isinstance(job.body, bytes) else job.body.read_bytes()
    cloud, beside = _read(body, job)
    options = check_options(job.query, beside, cloud.options)
    read_at = perf_counter()
    if job.if_none_match:
        tag = etag(receipt(cloud, options), cloud)
        if names(job.if_none_match, tag):
            raise AlreadyAnsweredError("the answer would be the one that you named", {"ETag": tag})
    content = answer(fit_cloud(cloud, options), cloud, options)
    seconds = {"read": read_at - started, "fit": perf_counter() - read_at}
    headers = {"ETag": etag(content["receipt"], cloud)}
    facts = _facts(content) | {"fit_seconds": round(seconds["fit"], 4)}
    return Reply(200, to_json(content), headers=headers, seconds=seconds, facts=facts)


def _facts(content: Mapping[str, Any]) -> dict[str, Any]:
    """What the log and the metrics say of an answer."""
    primitive = content["primitive"]
    return {
        "fit_status": content["status"],
        "fit_kind": None if primitive is None else primitive["kind"],
        "n_points": content["receipt"]["n_points"],
        "attempts": len(content["attempts"]),
    }


def _read(body: bytes, job: FitJob) -> tuple[Cloud, Mapping[str, Any]]:
    """The cloud, and the options that an upload holds beside it."""
    if job.media_type == "application/json":
        return read_json(memoryview(body), job.limits), {}
    parts: Mapping[str, bytes | memoryview] = {"file": body}
    if job.media_type == "multipart/form-data":
        parts = split_parts(body, job.content_type)
    if "file" not in parts:
        raise UnreadableFileError("file", "part file is missing", "missing")
    beside = parse_options(parts["options"]) if "options" in parts else {}
    return read(parts["file"], job.limits), beside
