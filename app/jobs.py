"""What a worker process does with one request: read, fit, and write the body of the response."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from app.answer import answer, to_json, versions
from app.engine import fit, fit_cloud
from app.exports import bundle
from app.exports.request import split_query
from app.multipart import split_parts
from app.options import check_options, parse_options
from app.problems import MEDIA_TYPE, problem
from app.readers import Cloud, Limits, UnreadableFileError, read, read_json

ZIP = "application/zip"
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


@dataclass(frozen=True)
class Reply:
    """A finished response, and the seconds that went into its steps."""

    status: int
    content: bytes
    media_type: str = "application/json"
    seconds: dict[str, float] = field(default_factory=dict)


def warm() -> dict[str, str | None]:
    """Load the weights and fit once, so that no request waits for an import; returns the versions."""
    grid = np.random.default_rng(0).uniform(-1.0, 1.0, (60, 3)) * [1.0, 1.0, 0.0]
    fit(grid)
    return versions("network")


def run(job: FitJob) -> Reply:
    """The response to one request; every failure is a problem document."""
    try:
        return _fit(job)
    except Exception as error:
        refused = problem(error, f"/requests/{job.request_id}")
        if refused.status >= 500:
            _log.exception("request %s failed", job.request_id)
        return Reply(refused.status, refused.content, MEDIA_TYPE)


def _fit(job: FitJob) -> Reply:
    started = perf_counter()
    query, wanted = split_query(job.query)
    body = job.body if isinstance(job.body, bytes) else job.body.read_bytes()
    cloud, beside = _read(body, job)
    options = check_options(query, beside, cloud.options)
    read_at = perf_counter()
    recognition = fit_cloud(cloud, options)
    content = to_json(answer(recognition, cloud, options))
    seconds = {"read": read_at - started, "fit": perf_counter() - read_at}
    if wanted is None:
        return Reply(200, content, seconds=seconds)
    return Reply(200, bundle(content, recognition, wanted), ZIP, seconds)


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
