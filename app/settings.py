"""Settings of the service, each from an environment variable PRIMFIT_<NAME>."""

import os
from pathlib import Path

from pydantic import Field
from pydantic_settings import BaseSettings, SettingsConfigDict

from app.readers.limits import Limits

MIB = 1024 * 1024


def _default_workers() -> int:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(4, cores)


class Settings(BaseSettings):
    """Limits, workers and where to listen."""

    model_config = SettingsConfigDict(env_prefix="PRIMFIT_", frozen=True)

    host: str = Field(default="127.0.0.1", description="address to listen on")
    port: int = Field(default=8000, ge=0, le=65535, description="port to listen on")
    workers: int = Field(
        default_factory=_default_workers, ge=1, le=256, description="processes that parse and fit"
    )
    max_body_bytes: int = Field(default=64 * MIB, ge=1, description="largest request body")
    max_points: int = Field(default=5_000_000, ge=1, description="most points of one cloud")
    max_json_points: int = Field(default=200_000, ge=1, description="most points of one cloud in JSON")
    fit_time_limit: float = Field(default=60.0, gt=0, description="seconds that reading and fitting may take")
    receive_timeout: float = Field(
        default=30.0, gt=0, description="seconds to wait for the next piece of a body"
    )
    send_timeout: float = Field(
        default=60.0, gt=0, description="seconds to wait until a client takes the next piece of a stream"
    )
    max_batch_items: int = Field(default=10_000, ge=1, description="most files and segments of one batch")
    queue_size: int = Field(default=64, ge=0, description="requests that may wait for a free worker")
    temporary_directory: Path | None = Field(
        default=None, description="where large bodies are kept while read"
    )

    @property
    def limits(self) -> Limits:
        """How much a reader may take in."""
        return Limits(self.max_points, self.max_json_points, self.max_body_bytes)
