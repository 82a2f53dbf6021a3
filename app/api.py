"""The service: routes that translate, an error table, and a pool of workers that read and fit."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib.metadata import version as version_of
from pathlib import Path
from time import perf_counter

from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.responses import HTMLResponse
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from app import jobs, openapi, problems
from app.body import received
from app.problems import NotReadyError, UnsupportedMediaTypeError
from app.readers import Limits
from app.request_id import RequestId
from app.schemas import FitAnswer, Live, Ready, Versions
from app.settings import Settings
from app.workers import WorkerPool

_DOCS = Path(__file__).with_name("docs.html")
router = APIRouter()


def create_app(settings: Settings | None = None) -> FastAPI:
    """The ASGI application; its workers start with it and end with it."""
    settings = settings or Settings()
    app = FastAPI(
        title="primfit",
        version=version_of("primfit"),
        description=openapi.DESCRIPTION,
        lifespan=_lifespan,
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,
    )
    app.state.settings = settings
    app.include_router(router)
    app.add_middleware(RequestId)
    for error in (*problems.KINDS, HTTPException, Exception):
        app.add_exception_handler(error, _refuse)
    app.add_exception_handler(ClientDisconnect, lambda request, error: Response(status_code=400))
    app.openapi = lambda: openapi.document(app)  # type: ignore[method-assign]
    return app


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    settings: Settings = app.state.settings
    app.state.pool = WorkerPool(
        settings.workers,
        jobs.warm,
        jobs.run,
        time_limit=settings.fit_time_limit,
        queue_size=settings.queue_size,
        preload=["app.jobs", "scipy.optimize", "scipy.spatial", "sklearn.neighbors"],
    )
    app.state.pool.start()
    try:
        yield
    finally:
        app.state.pool.stop()


@router.post("/fit", operation_id="fit", summary="Fit a cloud", response_model=FitAnswer, **openapi.FIT)
async def fit(request: Request) -> Response:
    """Say which primitive a cloud is, with its parameters, its error, and every kind that was tried."""
    media_type = _media_type(request)
    started = perf_counter()
    async with received(request, request.app.state.settings) as body:
        seconds = {"receive": perf_counter() - started}
        reply = await request.app.state.pool.run(_job(request, media_type, body), request.is_disconnected)
    if reply is None:
        raise ClientDisconnect
    seconds |= reply.seconds | {"total": perf_counter() - started}
    timing = ", ".join(f"{name};dur={1000 * value:.1f}" for name, value in seconds.items())
    return Response(reply.content, reply.status, {"Server-Timing": timing}, reply.media_type)


@router.get("/livez", operation_id="livez", summary="Is it alive?", response_model=Live, **openapi.GET)
async def livez() -> Live:
    """The process answers."""
    return Live(status="alive")


@router.get("/readyz", operation_id="readyz", summary="Is it ready?", response_model=Ready, **openapi.READYZ)
async def readyz(request: Request) -> Ready:
    """Workers are warm and the weights are loaded: clouds can be sent."""
    n_warm = request.app.state.pool.n_warm
    if not n_warm:
        raise NotReadyError("no worker is warm yet")
    return Ready(status="ready", workers=n_warm)


@router.get("/version", operation_id="version", summary="What is it?", response_model=Versions, **openapi.GET)
async def version(request: Request) -> Versions:
    """Versions that decide the numbers; `weights` is null until the workers are warm."""
    known = {name: version_of(name) for name in ("primfit", "numpy", "scipy")}
    return Versions(**{"weights": None, **known, **(request.app.state.pool.greeting or {})})


@router.get("/docs", include_in_schema=False)
async def docs() -> HTMLResponse:
    """The API in a browser, without anything from elsewhere."""
    return HTMLResponse(_DOCS.read_text())


def _media_type(request: Request) -> str:
    media_type = (
        request.headers.get("content-type", "application/octet-stream").partition(";")[0].strip().lower()
    )
    encoding = request.headers.get("content-encoding", "identity")
    if media_type not in openapi.MEDIA_TYPES or encoding != "identity":
        raise UnsupportedMediaTypeError(openapi.WHAT_IS_READ)
    return media_type


def _job(request: Request, media_type: str, body: bytes | Path) -> jobs.FitJob:
    settings: Settings = request.app.state.settings
    return jobs.FitJob(
        request.state.request_id,
        body,
        media_type,
        request.headers.get("content-type", ""),
        request.query_params.multi_items(),
        Limits(settings.max_points, settings.max_json_points, settings.max_body_bytes),
    )


async def _refuse(request: Request, error: Exception) -> Response:
    request_id = getattr(request.state, "request_id", "unknown")
    refused = problems.problem(error, f"/requests/{request_id}")
    headers = {**refused.headers, "X-Request-Id": request_id}
    return Response(refused.content, refused.status, headers, problems.MEDIA_TYPE)
