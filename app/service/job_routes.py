"""Jobs over HTTP: handed in, looked at, read, followed, canceled."""

from contextlib import AsyncExitStack
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import orjson
from fastapi import APIRouter, Request, Response
from starlette.requests import ClientDisconnect

from ..jobs.record import ACCEPTED, DISMISSED, FAILED, RUNNING, SUCCESSFUL, Job
from ..readers.errors import FieldError, describe
from ..wire.job_schemas import JobList, JobStatus
from ..wire.problems import InvalidOptionsError, JobsOffError, NoSuchJobError
from ..workers.jobs import Reply
from . import operations
from .batch_stream import Lines
from .body import announced, is_large, received, size
from .media_types import NDJSON, coding_of, media_type_of
from .parameters import DEFAULT_PAGE, LARGEST_OFFSET, LARGEST_PAGE
from .prefer import preferences

if TYPE_CHECKING:
    from ..jobs.desk import Desk

router = APIRouter()
_KEY_LENGTH = 255
_RESULTS = "http://www.opengis.net/def/rel/ogc/1.0/results"
_MESSAGES = {
    ACCEPTED: "it waits for its turn",
    RUNNING: "it is worked on",
    SUCCESSFUL: "all items are answered",
    FAILED: "it could not be done; `problem` says why",
    DISMISSED: "it was canceled",
}


class EventStream(Lines):
    """Server-sent events."""

    media_type = "text/event-stream"


@router.post(
    "/jobs",
    operation_id="submit_job",
    summary="Hand in a batch, and ask for its results later",
    status_code=202,
    response_model=JobStatus,
    **operations.SUBMIT_JOB,
)
async def submit_job(request: Request) -> Response:
    """Fit many clouds as a job: takes what `POST /fit/batch` takes, and keeps its answer line by line."""
    return await submit(request)


async def submit(request: Request) -> Response:
    """A batch as a job: the disk holds it when this is answered."""
    desk, settings, key = _desk(request), request.app.state.settings, _idempotency_key(request)
    asked = {
        "request_id": request.state.request_id,
        "media_type": media_type_of(request),
        "content_type": request.headers.get("content-type", ""),
        "coding": coding_of(request),
        "query": request.query_params.multi_items(),
    }
    from .job_work import new_job, open_job

    pool, spool = request.app.state.pool, request.app.state.spool
    pool.check_room(is_large(announced(request)))
    async with AsyncExitStack() as resources:
        body = await resources.enter_async_context(received(request, settings.max_body_bytes, spool))
        unpacked = Path(resources.enter_context(spool.file()).name) if asked["coding"] else None
        opening = open_job(asked, body, unpacked, settings)
        opened = await pool.run(opening, request.is_disconnected, large=is_large(size(body)))
        if opened is None:
            raise ClientDisconnect
        if isinstance(opened, Reply):
            request.state.facts |= opened.facts
            return Response(opened.content, opened.status, opened.headers, opened.media_type)
        new = await desk.call(new_job, _owner(request), key, asked, body, unpacked or body, opened)
        job = await desk.submit(new, body)
    request.state.facts["job"] = job.id
    headers = {"Location": _path(request, job.id)}
    if wants_job(request):
        headers["Preference-Applied"] = "respond-async"
    return _json(await _status(request, job), 202, headers)


def wants_job(request: Request) -> bool:
    """Whether the client would rather have a job than wait, and the service keeps some."""
    return "respond-async" in preferences(request.headers) and request.app.state.desk is not None


@router.get(
    "/jobs",
    operation_id="list_jobs",
    summary="Which jobs are there?",
    response_model=JobList,
    **operations.LIST_JOBS,
)
async def list_jobs(request: Request) -> Response:
    """The jobs of this client that are kept."""
    desk = _desk(request)
    jobs = await desk.listed(_owner(request))
    shown = [await _status(request, job) for job in jobs]
    links = [{"href": _path(request), "rel": "self", "type": "application/json"}]
    return _json({"jobs": shown, "links": links})


@router.get(
    "/jobs/{job_id}",
    operation_id="job_status",
    summary="How far is a job?",
    response_model=JobStatus,
    **operations.JOB_STATUS,
)
async def job_status(request: Request) -> Response:
    """The status of a job, its progress, its place in the queue, and where its results are."""
    return _json(await _status(request, await _job(request)))


@router.get(
    "/jobs/{job_id}/results",
    operation_id="job_results",
    summary="What is found so far?",
    response_class=Lines,
    **operations.JOB_RESULTS,
)
async def job_results(request: Request) -> Response:
    """Lines of `POST /fit/batch` as far as they are there, from `offset` on, at most `limit` of them.

    The header `Link` says where the next ones are, or will be; after the last of all it is not there.
    """
    desk, job = _desk(request), await _job(request)
    offset = _number(request, "offset", 0, 0, LARGEST_OFFSET)
    limit = _number(request, "limit", DEFAULT_PAGE, 1, LARGEST_PAGE)
    from .job_stream import pieces

    progress = job.progress
    try:
        stretches = await desk.call(desk.folder.of(job.id).page, progress.parts, offset, limit)
    except FileNotFoundError:
        await _job(request)  # which says so where it was removed meanwhile
        raise NoSuchJobError("the results of this job are gone") from None
    response = Lines(pieces(desk, stretches), AsyncExitStack())
    response.headers["Content-Length"] = str(sum(each.stop - each.start for each in stretches))
    following = min(offset + limit, max(offset, progress.lines))
    if following < progress.lines or not job.ended:
        response.headers["Link"] = f'<?offset={following}&limit={limit}>; rel="next"'
    return response


@router.get(
    "/jobs/{job_id}/events",
    operation_id="job_events",
    summary="Follow a job",
    response_class=EventStream,
    **operations.JOB_EVENTS,
)
async def job_events(request: Request) -> Response:
    """Server-sent events: `status` whenever it changes, `result` for each line; ends with the job.

    After a break, `Last-Event-ID` says which line was the last one; 204 when nothing is left to tell.
    """
    desk, job = _desk(request), await _job(request)
    from .job_stream import END, Events

    last = request.headers.get("last-event-id", "").strip() or "0"
    if last == END:
        return Response(status_code=204)
    if not (last.isdecimal() and len(last) < 19):
        raise InvalidOptionsError([FieldError("Last-Event-ID", "not the id of an event", describe(last))])
    if request.method == "HEAD":  # its end would be that of the job
        return Response(media_type=EventStream.media_type)
    state = request.app.state

    async def shown(job: Job) -> dict[str, Any]:
        return await _status(request, job)

    events = Events(desk, job, shown, lambda: state.stopping)
    response = EventStream(events.stream(int(last)), AsyncExitStack())
    # A proxy that gathered them would defeat them.
    response.headers.update({"Cache-Control": "no-cache", "X-Accel-Buffering": "no"})
    return response


@router.delete(
    "/jobs/{job_id}",
    operation_id="dismiss_job",
    summary="Cancel a job, or remove it after its end",
    response_model=JobStatus,
    **operations.DISMISS_JOB,
)
async def dismiss_job(request: Request) -> Response:
    """Work on it ends, and what was found stays until it expires; a job that has ended is removed."""
    desk, job = _desk(request), await _job(request)
    await desk.call(desk.dismiss, job)
    left = await desk.call(desk.store.find, job.id)
    return _json(await _status(request, left or replace(job, status=DISMISSED)))


def _desk(request: Request) -> "Desk":
    desk: Desk | None = request.app.state.desk
    if desk is None:
        raise JobsOffError("jobs are kept where the setting jobs_path names a folder; POST /fit/batch works")
    return desk


def _owner(request: Request) -> str:
    """The name of the client's key; without keys everybody is the same."""
    return request.state.facts.get("client") or ""


async def _job(request: Request) -> Job:
    return await _desk(request).find(request.path_params["job_id"], _owner(request))


def _idempotency_key(request: Request) -> str | None:
    """The key, which may stand in quotes (draft-ietf-httpapi-idempotency-key-header)."""
    given = request.headers.get("idempotency-key")
    if given is None:
        return None
    key = given.strip()
    if len(key) > 1 and key[0] == key[-1] == '"':
        key = key[1:-1]
    if not key or len(key) > _KEY_LENGTH or not key.isascii() or not key.isprintable():
        raise InvalidOptionsError(
            [FieldError("Idempotency-Key", f"1 to {_KEY_LENGTH} printable characters of ASCII are needed")]
        )
    return key


def _number(request: Request, name: str, default: int, least: int, most: int) -> int:
    given = request.query_params.getlist(name)
    if not given:
        return default
    text = given[0]
    value = int(text) if text.isascii() and text.isdecimal() and len(text) <= len(str(most)) else -1
    if len(given) > 1 or not least <= value <= most:
        message = f"one integer from {least} to {most} is needed"
        raise InvalidOptionsError([FieldError(name, message, describe(text))])
    return value


def _path(request: Request, job_id: str | None = None) -> str:
    """Where jobs are, seen from this request: no proxy says which prefix it has taken away."""
    depth = request.scope["path"].removeprefix(request.scope.get("root_path", "")).count("/")
    jobs = "../" * (depth - 1) + "jobs"
    return jobs if job_id is None else f"{jobs}/{job_id}"


async def _status(request: Request, job: Job) -> dict[str, Any]:
    """The document of a job; `JobStatus`, without what does not apply."""
    place = await _desk(request).place(job) if job.status == ACCEPTED else None
    path = _path(request, job.id)
    document = {
        "jobID": job.id,
        "processID": "fit_batch",
        "type": "process",
        "status": job.status,
        "message": _MESSAGES[job.status],
        "progress": job.progress.percent,
        "created": _time(job.created),
        "updated": _time(job.updated),
        "started": _time(job.started),
        "finished": _time(job.finished),
        "expires": _time(job.expires),
        "queue_place": place,
        "files": job.n_files,
        "lines": job.progress.lines,
        "summary": job.summary,
        "problem": job.problem,
        "links": [
            {"href": path, "rel": "self", "type": "application/json"},
            {"href": f"{path}/results", "rel": _RESULTS, "type": NDJSON},
            {"href": f"{path}/events", "rel": "monitor", "type": EventStream.media_type},
        ],
    }
    return {name: value for name, value in document.items() if value is not None}


def _time(seconds: float | None) -> str | None:
    if seconds is None:
        return None
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _json(document: Any, status: int = 200, headers: dict[str, str] | None = None) -> Response:
    return Response(orjson.dumps(document), status, headers, "application/json")
