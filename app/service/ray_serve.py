"""The service as an application of Ray Serve, whose replicas come and go with the queue.

`serve run primfit.app.service.ray_serve:app max_replicas=8` starts it on the cluster that it finds.

Each replica is the whole service with a worker of its own. What a service counts or keeps for itself would
be counted and kept once a replica: settings of that kind are refused.
"""

from fastapi import FastAPI
from pydantic import BaseModel, ConfigDict, Field
from ray import serve
from ray.serve import Application
from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ..workers import logs
from .api import create_app
from .settings import Settings, SettingsError, load

LISTENER = (
    "trusted_proxies",
    "max_connections",
    "first_byte_timeout",
    "head_timeout",
    "keep_alive_timeout",
    "receive_timeout",
    "send_timeout",
    "min_rate",
    "transfer_time_limit",
    "stop_delay",
    "stop_patience",
)
"""Settings of who listens, which is Ray Serve here."""

_MOST_AT_A_REPLICA = 4
"""Times the target. More wait in front of all replicas, where one that is new finds them."""


class Arguments(BaseModel):
    """What stands behind the name of the application; Ray's own names for autoscaling."""

    model_config = ConfigDict(extra="forbid")

    min_replicas: int = Field(default=1, ge=1)
    max_replicas: int = Field(default=4, ge=1)
    target_ongoing_requests: float = Field(default=2.0, gt=0)
    upscale_delay_s: float = Field(default=10.0, ge=0)
    downscale_delay_s: float = Field(default=300.0, ge=0)


def app(arguments: Arguments) -> Application:
    """The application, as Ray Serve builds it; raises `SettingsError`."""
    settings, target = replica_settings(), arguments.target_ongoing_requests
    service = serve.deployment(serve.ingress(_service)())
    return service.options(
        name="primfit",
        ray_actor_options={"num_cpus": settings.workers},
        max_ongoing_requests=max(1, round(_MOST_AT_A_REPLICA * target)),
        max_queued_requests=max(1, settings.queue_size * arguments.max_replicas),
        autoscaling_config=arguments.model_dump(),
    ).bind()


def _service() -> FastAPI:
    """What a replica serves; its settings are those of the machine that it is on."""
    settings = replica_settings()
    logs.configure(settings.log_format)
    made = create_app(settings)
    made.add_middleware(_IdOnce)
    return made


class _IdOnce:
    """Leaves out `X-Request-Id`, which Ray Serve's proxy adds: it has told us the same id."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def send_without_id(message: Message) -> None:
            if message["type"] == "http.response.start":
                del MutableHeaders(scope=message)["X-Request-Id"]
            await send(message)

        await self.app(scope, receive, send_without_id)


def replica_settings() -> Settings:
    """The settings in force, with one worker unless they say how many.

    Raises
    ------
    SettingsError
        They cannot be used, or not by several replicas.
    """
    settings = load()
    complaints = [
        f"{name}: it has no effect under Ray Serve, whose proxy listens; limit connections in front of that"
        for name in LISTENER
        if name in settings.model_fields_set
    ]
    if settings.rate_limit is not None:
        complaints.append("rate_limit: each replica would count for itself; limit requests in front of them")
    if settings.jobs_path is not None and settings.jobs_database is None:
        complaints.append(
            "jobs_path: replicas may be on several machines, which SQLite does not bear: "
            "jobs_database is needed, too"
        )
    if complaints:
        raise SettingsError(*complaints)
    alone = {} if "workers" in settings.model_fields_set else {"workers": 1}
    return settings.model_copy(update=alone)
