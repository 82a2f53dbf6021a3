"""The service: routes that translate, an error table, and a pool of workers that read and fit."""

import os
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from functools import cache, partial
from importlib.metadata import version as version_of
from pathlib import Path
from time import perf_counter, time_ns

import orjson
from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.responses import HTMLResponse, PlainTextResponse
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.types import ASGIApp, Receive, Scope, Send

from ..wire import problems
from ..wire.problems import NotReadyError
from ..wire.schemas import Capabilities, FitAnswer, Live, Ready, Versions
from ..workers import PRELOAD, jobs
from ..workers.batch_jobs import OpenJob
from ..workers.request_id import RequestId
from . import docs_page, job_routes, metrics, openapi, operations, tracing, viewer
from .batch_stream import Batch, Lines
from .body import announced, is_large, received, size
from .browsers import Addressee, share_with
from .capabilities import capabilities
from .guard import Access, Guard
from .jobs_kept import jobs_kept
from .media_types import coding_of, media_type_of
from .methods import answer_head_and_options
from .observe import Observer
from .prefer import wait
from .routes import RouteNames
from .settings import Settings, load
from .spool import Spool
from .team import worker_pool

_INSTALLED = {name: version_of(name) for name in ("primfit", "numpy", "scipy")}
requests, router = APIRouter(), APIRouter()
"""What fits clouds, and the rest."""

_REFUSED = tuple(problems.KINDS)


class Zip(Response):
    """Files in one archive."""

    media_type = jobs.ZIP


def create_app(settings: Settings | None = None, local: bool = False) -> FastAPI:
    """The ASGI application; its workers start with it and end with it.

    `local` says that only this machine reaches it, so that it answers to names of this machine only.
    """
    settings = settings or load()
    app = FastAPI(
        title="primfit",
        version=version_of("primfit"),
        description=openapi.DESCRIPTION,
        lifespan=_lifespan,
        openapi_url=None,
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,
        # Its spans would tell the values of queries: `tracing`.
        telemetry={"tracing": False, "metrics": False, "logs": False, "auto_configure": False},
    )
    app.state.settings = settings
    app.state.metrics = metrics.Metrics()
    app.state.stopping = False
    app.include_router(requests)
    app.include_router(job_routes.router)
    app.include_router(router)
    answer_head_and_options(app, requests, job_routes.router, router)
    # The last one added sees a request first.
    app.add_middleware(Shortcut)
    app.state.access = Access(settings.keys(), settings.rate_limit)
    app.add_middleware(Guard, access=app.state.access)
    share_with(app, settings.cors_origins)
    app.add_middleware(Addressee, hosts=settings.allowed_hosts, local=local, origins=settings.cors_origins)
    names = RouteNames([*app.routes, *requests.routes, *job_routes.router.routes, *router.routes])
    app.add_middleware(Observer, metrics=app.state.metrics, routes=names)
    if (provider := tracing.provider()) is not None:
        app.add_middleware(tracing.Tracing, provider=provider, routes=names)
    app.add_middleware(RequestId)
    for error in (*problems.KINDS, HTTPException, Exception):
        app.add_exception_handler(error, _refuse)
    app.add_exception_handler(ClientDisconnect, _gone)
    app.openapi = lambda: openapi.document(app)  # type: ignore[method-assign]
    app.state.openapi = cache(lambda: orjson.dumps(app.openapi()))
    return app


class Shortcut:
    """Hands requests with a cloud to their functions, which take the request and make the response.

    The way through the router, with all that it solves, checks and closes for such a function, is as long as
    that through the rest of the service; what takes it still, as under a prefix, is answered alike.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app
        self._routes = {route.path: route for route in requests.routes if isinstance(route, APIRoute)}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        route = self._routes.get(scope["path"]) if scope.get("method") == "POST" else None
        if route is None:
            await self.app(scope, receive, send)
            return
        scope["route"], request = route, Request(scope, receive, send)
        try:
            response = await route.endpoint(request)
        except ClientDisconnect as error:
            response = _gone(request, error)
        except _REFUSED as error:
            response = problems.respond(request, error)
        await response(scope, receive, send)


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    settings: Settings = app.state.settings
    app.state.spool = Spool(settings.temporary_directory, settings.max_spooled_bytes, os.getpid())
    app.state.pool = worker_pool(settings, app.state.spool, PRELOAD)
    app.state.metrics.watch(app.state.pool)
    app.state.pool.start()
    try:
        async with jobs_kept(app):
            yield
    finally:
        app.state.pool.stop()


@requests.post("/fit", operation_id="fit", summary="Fit a cloud", response_model=FitAnswer, **operations.FIT)
async def fit(request: Request) -> Response:
    """Say which primitive a cloud is, with its parameters, its error, and every kind that was tried."""
    return await _fitted(request, export=False)


@requests.post(
    "/fit/export",
    operation_id="fit_export",
    summary="Fit a cloud, and export what was found",
    response_class=Zip,
    **operations.FIT_EXPORT,
)
async def fit_export(request: Request) -> Response:
    """Fit a cloud, and hand out the trimmed primitive, residuals, a report and the answer in a ZIP."""
    return await _fitted(request, export=True)


async def _fitted(request: Request, export: bool) -> Response:
    media_type, coding = media_type_of(request), coding_of(request)
    state, patience = request.app.state, wait(request.headers)
    started = perf_counter()
    state.pool.check_room(is_large(announced(request)), patience)
    async with received(request, state.settings.max_body_bytes, state.spool) as body:
        seconds = {"receive": perf_counter() - started}
        reply = await state.pool.run(
            _job(request, media_type, coding, body, export),
            request.is_disconnected,
            large=is_large(size(body)),
            patience=patience,
        )
    if reply is None:
        raise ClientDisconnect
    request.state.facts |= reply.facts
    request.state.worked = reply.seconds, time_ns()
    seconds |= reply.seconds | {"total": perf_counter() - started}
    timing = ", ".join(f"{name};dur={1000 * value:.2f}" for name, value in seconds.items())
    headers = {**reply.headers, "Server-Timing": timing}
    if patience is not None:
        headers["Preference-Applied"] = f"wait={min(patience, state.settings.fit_time_limit):g}"
    return Response(reply.content, reply.status, headers, reply.media_type)


@requests.post(
    "/fit/batch",
    operation_id="fit_batch",
    summary="Fit many clouds",
    response_class=Lines,
    **operations.FIT_BATCH,
)
async def fit_batch(request: Request) -> Response:
    """Fit many clouds, and the segments of clouds whose points have labels; the answers come line by line.

    With `Prefer: respond-async` it becomes a job where the service keeps some, as by `POST /jobs`.
    """
    if job_routes.wants_job(request):
        return await job_routes.submit(request)
    media_type, coding = media_type_of(request), coding_of(request)
    settings, pool, spool = request.app.state.settings, request.app.state.pool, request.app.state.spool
    pool.check_batch()
    async with AsyncExitStack() as resources:
        body = await resources.enter_async_context(received(request, settings.max_body_bytes, spool))
        run = resources.enter_context(pool.batch())
        unpacked = Path(resources.enter_context(spool.file()).name) if coding else None
        job = _open_job(request, media_type, coding, body, unpacked)
        opened = await pool.run(job, request.is_disconnected, large=is_large(size(body)))
        if opened is None:
            raise ClientDisconnect
        if isinstance(opened, jobs.Reply):
            request.state.facts |= opened.facts
            return Response(opened.content, opened.status, opened.headers, opened.media_type)
        if unpacked is not None:
            resources.enter_context(spool.share()).reach(size(unpacked))
        scratch = resources.enter_context(spool.files())
        kept = resources.pop_all()
    run = partial(run, abandoned=request.is_disconnected)
    metrics, facts = request.app.state.metrics, request.state.facts
    batch = Batch(
        request.state.request_id,
        unpacked or body,
        media_type,
        opened,
        settings,
        scratch,
        run,
        pool.size,
        metrics,
        facts,
    )
    return Lines(batch.lines(), kept)


@router.get("/livez", operation_id="livez", summary="Is it alive?", response_model=Live, **operations.GET)
async def livez() -> Live:
    """The process answers."""
    return Live(status="alive")


@router.get(
    "/readyz", operation_id="readyz", summary="Is it ready?", response_model=Ready, **operations.READYZ
)
async def readyz(request: Request) -> Ready:
    """Workers are warm and the weights are loaded: clouds can be sent."""
    if request.app.state.stopping:
        raise NotReadyError("the service is about to stop")
    n_warm = request.app.state.pool.n_warm
    if not n_warm:
        raise NotReadyError("no worker is warm yet")
    return Ready(status="ready", workers=n_warm)


@router.get(
    "/version", operation_id="version", summary="What is it?", response_model=Versions, **operations.GET
)
async def version(request: Request) -> Versions:
    """Versions that decide the numbers; `weights` is null until the workers are warm."""
    return _versions(request)


@router.get(
    "/capabilities",
    operation_id="capabilities",
    summary="What can it do?",
    response_model=Capabilities,
    **operations.GET,
)
def what_it_can_do(request: Request) -> Capabilities:
    """Kinds, classifiers, criteria, formats, options and limits of this service."""
    return capabilities(request.app.state.settings, _versions(request))


@router.get(
    "/metrics",
    operation_id="metrics",
    summary="How is it used?",
    response_class=PlainTextResponse,
    **operations.METRICS,
)
async def read_metrics(request: Request) -> Response:
    """Counters and histograms in the text format of Prometheus."""
    return Response(request.app.state.metrics.text(), media_type=metrics.MEDIA_TYPE)


@router.get(viewer.ROOT, include_in_schema=False)
async def root(request: Request) -> Response:
    """A page that shows clouds and their fits."""
    return viewer.page(request)


@router.get(viewer.PREFIX + "{name}", include_in_schema=False)
async def part_of_page(request: Request, name: str) -> Response:
    """What the page consists of."""
    found = viewer.part(request, name)
    if found is None:
        raise HTTPException(404)
    return found


@router.get("/openapi.json", include_in_schema=False)
async def document(request: Request) -> Response:
    """The OpenAPI document, written once: nobody needs a key for it, and it is large."""
    return Response(request.app.state.openapi(), media_type="application/json")


@router.get("/docs", include_in_schema=False)
async def docs() -> HTMLResponse:
    """The API in a browser, without anything from elsewhere."""
    document, headers = docs_page.page()
    return HTMLResponse(document, headers=headers)


def _versions(request: Request) -> Versions:
    return Versions(**{"weights": None, **_INSTALLED, **(request.app.state.pool.greeting or {})})


def _job(
    request: Request, media_type: str, coding: str | None, body: bytes | Path, export: bool
) -> jobs.FitJob:
    settings: Settings = request.app.state.settings
    return jobs.FitJob(
        request.state.request_id,
        body,
        media_type,
        request.headers.get("content-type", ""),
        coding,
        request.query_params.multi_items(),
        settings.limits,
        ", ".join(request.headers.getlist("if-none-match")),
        export,
    )


def _open_job(
    request: Request, media_type: str, coding: str | None, body: bytes | Path, unpacked: Path | None
) -> OpenJob:
    settings: Settings = request.app.state.settings
    return OpenJob(
        request.state.request_id,
        body,
        media_type,
        request.headers.get("content-type", ""),
        coding,
        unpacked,
        request.query_params.multi_items(),
        settings.limits,
        settings.max_batch_items,
    )


async def _refuse(request: Request, error: Exception) -> Response:
    return problems.respond(request, error)


def _gone(request: Request, error: Exception) -> Response:
    """There is nobody to tell."""
    return Response(status_code=400)
