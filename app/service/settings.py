"""Settings of the service: flags of `primfit serve`, else PRIMFIT_<NAME> in the environment, else a file."""

import importlib.util
import ipaddress
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import limits
from pydantic import AfterValidator, BeforeValidator, DirectoryPath, Field, SecretStr, ValidationError
from pydantic_settings import (
    BaseSettings,
    NoDecode,
    PydanticBaseSettingsSource,
    SettingsConfigDict,
    TomlConfigSettingsSource,
)

from ..engine.executors import Executor
from ..readers.limits import RATIO, Limits
from .budgets import points_by_criterion
from .keys import Keys

MIB = 1024 * 1024
DAY = 86400.0
PREFIX = "PRIMFIT_"
CONFIG = f"{PREFIX}CONFIG"
SECRET = ("api_keys", "jobs_database")
"""Settings that are not shown."""
_VALUE_LENGTH = 60
_MOST_CONNECTIONS = 1000
"""Each may hold some hundred kilobytes of what has arrived: of so many the main process is not in danger."""


class SettingsError(Exception):
    """Settings that cannot be used; `complaints` name each with its value and what it may be."""

    def __init__(self, *complaints: str) -> None:
        super().__init__("; ".join(complaints))
        self.complaints = complaints


def _default_workers() -> int:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(4, cores)


def _split(value: Any) -> Any:
    """The items of a list, which stands in an environment variable with commas between them."""
    return [item.strip() for item in value.split(",") if item.strip()] if isinstance(value, str) else value


def _rate(text: str) -> str:
    try:
        amounts = [rate.amount for rate in limits.parse_many(text)]
    except ValueError:
        amounts = []
    if len(amounts) != 1 or amounts[0] < 1:
        raise ValueError('a number of requests in a time is needed, such as "120/minute" or "5/2seconds"')
    return text


def _proxy(text: str) -> str:
    if text != "*":
        try:
            ipaddress.ip_network(text)
        except ValueError:
            raise ValueError("an IP address, a network such as 10.0.0.0/8, or * is needed") from None
    return text


def _origin(text: str) -> str:
    """As a browser sends it, so that the two can be compared."""
    if text != "*" and not re.fullmatch(r"(?i)https?://[^\s/?#@]+", text):
        raise ValueError("an origin such as https://viewer.example.com:8443, without a path, or * is needed")
    return text.lower()


def _host_name(text: str) -> str:
    """A host without a port, or a pattern of it; addresses of IPv6 stand in brackets, as in `Host`."""
    if text != "*" and not re.fullmatch(r"(\*\.)?[\w-]+(\.[\w-]+)*|\[[0-9a-fA-F:.]+\]", text):
        raise ValueError(
            "a name such as primfit.example.com or *.example.com, without a port, or * is needed"
        )
    return text.lower()


def _default_connections() -> int:
    """A third of the descriptors for connections, one for bodies that are kept in files, one for all else."""
    return max(1, min(_MOST_CONNECTIONS, _most_files() // 3))


def _most_files() -> int:
    try:
        import resource
    except ImportError:  # not a system of POSIX, and without such a limit
        return 3 * _MOST_CONNECTIONS
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return 3 * _MOST_CONNECTIONS if soft == resource.RLIM_INFINITY else soft


_URL_NEEDED = "a URL such as postgresql://USER:PASSWORD@HOST:PORT/DATABASE is needed"


def _postgresql(url: SecretStr) -> SecretStr:
    if not re.match(r"postgres(ql)?://[^/]", url.get_secret_value()):
        raise ValueError(_URL_NEEDED)
    from sqlalchemy import make_url  # slow to import, and needed only here
    from sqlalchemy.exc import ArgumentError

    try:
        port = make_url(url.get_secret_value()).port
    except (ArgumentError, ValueError):
        raise ValueError(f"{_URL_NEEDED}; PORT is a number") from None
    if port is not None and not 0 < port < 65536:
        raise ValueError(f"{_URL_NEEDED}; PORT is {port}, and must be from 1 to 65535")
    return url


class Settings(BaseSettings):
    """Where to listen, who may ask, how much, and what is told of it."""

    model_config = SettingsConfigDict(
        env_prefix=PREFIX, env_ignore_empty=True, frozen=True, extra="forbid", hide_input_in_errors=True
    )

    host: str = Field(default="127.0.0.1", description="address to listen on")
    port: int = Field(default=8000, ge=0, le=65535, description="port to listen on; 0 takes a free one")
    workers: int = Field(
        default_factory=_default_workers,
        ge=1,
        le=256,
        description="processes that read and fit, one thread each",
        json_schema_extra={"x-default": "cores, at most 4"},
    )
    max_body_bytes: int = Field(default=64 * MIB, ge=1, description="largest request body")
    max_points: int = Field(default=5_000_000, ge=1, description="most points of one cloud")
    max_json_points: int = Field(default=200_000, ge=1, description="most points of one cloud in JSON")
    fit_time_limit: float = Field(
        default=60.0,
        gt=0,
        le=DAY,
        description="seconds that a request may wait and be worked on once its body is there; "
        "for an item of a batch from when it is begun",
    )
    receive_timeout: float = Field(
        default=30.0,
        gt=0,
        le=DAY,
        description="seconds over which the rate of a body is averaged",
    )
    send_timeout: float = Field(
        default=60.0,
        gt=0,
        le=DAY,
        description="seconds over which the rate is averaged at which a client takes its answer",
    )
    max_batch_items: int = Field(default=10_000, ge=1, description="most files and segments of one batch")
    queue_size: int = Field(
        default=64, ge=0, description="requests with small clouds that may wait; as many with large ones, too"
    )
    worker_memory: int = Field(
        default=1024 * MIB,
        ge=64 * MIB,
        description="bytes that reading and fitting one cloud may take in a worker (Linux)",
    )
    max_spooled_bytes: int | None = Field(
        default=None,
        ge=0,
        description="bytes of bodies that may be in the temporary directory at one time, "
        "unpacked ones of batches included; the points of their segments come on top",
        json_schema_extra={"x-default": "half of what is free there at the start"},
    )
    temporary_directory: DirectoryPath | None = Field(
        default=None,
        description="where bodies over 128 KiB, and the points of a batch, are kept meanwhile",
        json_schema_extra={"x-default": "the system's"},
    )
    api_keys: Annotated[tuple[SecretStr, ...], NoDecode, BeforeValidator(_split)] = Field(
        default=(),
        description="keys that clients must send, each `KEY` or `NAME:KEY`, a KEY of 16 to 200 characters; "
        "without any, everybody may ask",
    )
    api_keys_file: Path | None = Field(
        default=None, description="file with more of them, one a line; lines that begin with # are comments"
    )
    rate_limit: Annotated[str, AfterValidator(_rate)] | None = Field(
        default=None,
        description='most requests of one client in a time, such as "120/minute"; a client is its key, '
        "else its address",
    )
    trusted_proxies: Annotated[
        tuple[Annotated[str, AfterValidator(_proxy)], ...], NoDecode, BeforeValidator(_split)
    ] = Field(
        default=(),
        description="addresses or networks of proxies whose `X-Forwarded-For` says who the client is; "
        "`*` trusts everybody",
    )
    cors_origins: Annotated[
        tuple[Annotated[str, AfterValidator(_origin)], ...], NoDecode, BeforeValidator(_split)
    ] = Field(
        default=(),
        description="origins of web pages whose scripts may ask, such as https://viewer.example.com; "
        "`*` stands for all of them, and without any only pages of the service itself may",
    )
    jobs_path: Path | None = Field(
        default=None,
        description="folder that keeps jobs, made where it is missing; several services may share one; "
        "without it there are no jobs",
    )
    jobs_database: Annotated[SecretStr, AfterValidator(_postgresql)] | None = Field(
        default=None,
        description="URL of a PostgreSQL database for the records of the jobs, such as "
        "postgresql://primfit:PASSWORD@db/primfit; needs the extra `postgres`",
        json_schema_extra={"x-default": "SQLite in `jobs_path`"},
    )
    jobs_executor: Executor = Field(
        default="local",
        description="who works on jobs: the processes of this service, or a Ray cluster (extra `ray`), all "
        "machines of which reach `jobs_path` under the same path",
    )
    jobs_address: str | None = Field(
        default=None,
        description="HOST:PORT of the cluster",
        json_schema_extra={"x-default": "that of `RAY_ADDRESS`, or of one on this machine"},
    )
    jobs_keep: float = Field(
        default=DAY, gt=0, le=366 * DAY, description="seconds that a job and its results stay after its end"
    )
    jobs_per_client: int = Field(default=100, ge=1, description="most jobs that are kept for one client")
    job_bytes_per_client: int = Field(
        default=1024 * MIB,
        ge=1,
        description="most bytes of bodies and results with which a client may hand in another job",
    )
    log_format: Literal["text", "json"] = Field(
        default="text", description="one line an event, for people or for machines"
    )
    stop_delay: float = Field(
        default=0.0,
        ge=0,
        le=DAY,
        description="seconds after SIGTERM in which requests are still taken while `/readyz` says 503",
    )
    stop_patience: int = Field(
        default=10, ge=0, le=DAY, description="seconds that requests under way may take to finish after that"
    )
    max_connections: int = Field(
        default_factory=_default_connections,
        ge=1,
        description="most connections at a time; beyond, the one that waits longest for a request is closed, "
        "or, where all have one, the new one is refused",
        json_schema_extra={"x-default": "a third of the open files that the system allows, at most 1000"},
    )
    first_byte_timeout: float = Field(
        default=30.0, gt=0, le=DAY, description="seconds until the first byte of a connection has to come"
    )
    head_timeout: float = Field(
        default=10.0,
        gt=0,
        le=DAY,
        description="seconds from the first byte of a request to the end of its head",
    )
    keep_alive_timeout: float = Field(
        default=60.0, gt=0, le=DAY, description="seconds to wait on a connection for the next request"
    )
    min_rate: float = Field(
        default=1000.0,
        ge=0,
        description="least bytes a second at which a body has to arrive, and an answer has to be taken",
    )
    transfer_time_limit: float = Field(
        default=600.0,
        gt=0,
        le=DAY,
        description="seconds to wait in all for a body to arrive, or for an answer to be taken",
    )
    allowed_hosts: Annotated[
        tuple[Annotated[str, AfterValidator(_host_name)], ...], NoDecode, BeforeValidator(_split)
    ] = Field(
        default=(),
        description="names in the header `Host` under which the service may be asked, such as "
        "primfit.example.com or *.example.com; `*` stands for all of them. Without any, a service on a "
        "loopback address takes only names of that, and others take all",
    )

    @classmethod
    def settings_customise_sources(
        cls,
        settings_cls: type[BaseSettings],
        init_settings: PydanticBaseSettingsSource,
        env_settings: PydanticBaseSettingsSource,
        dotenv_settings: PydanticBaseSettingsSource,
        file_secret_settings: PydanticBaseSettingsSource,
    ) -> tuple[PydanticBaseSettingsSource, ...]:
        """Flags win over the environment, which wins over the file."""
        return init_settings, env_settings, _file(settings_cls)

    @property
    def limits(self) -> Limits:
        """How much may be read, and fitted."""
        return Limits(
            self.max_points, self.max_json_points, self.max_body_bytes, RATIO, self.points_by_criterion
        )

    @property
    def points_by_criterion(self) -> dict[str, int]:
        """The most points that each criterion is done with in time."""
        return points_by_criterion(self.fit_time_limit, self.max_points)

    def keys(self) -> Keys:
        """The API keys of both places; `ValueError` or `OSError` where they cannot be used."""
        return Keys.read([key.get_secret_value() for key in self.api_keys], self.api_keys_file)


RENEWABLE = (
    "api_keys",
    "api_keys_file",
    "rate_limit",
    "max_body_bytes",
    "max_points",
    "max_json_points",
    "max_batch_items",
)
"""Settings that SIGHUP has read again; the others hold until the service is started anew."""


def load(**flags: Any) -> Settings:
    """The settings in force, with everything checked that can be checked before the service starts.

    Raises
    ------
    SettingsError
        A setting is unknown or out of range, or a file cannot be read.
    """
    try:
        settings = Settings(**flags)
        settings.keys()
        _check_jobs(settings)
    except ValidationError as error:
        found = error.errors(include_url=False, include_context=False)
        raise SettingsError(*(_complaint(one, flags) for one in found)) from None
    except OSError as error:
        raise SettingsError(f"{error.filename}: {error.strerror}") from None
    except ValueError as error:
        raise SettingsError(str(error)) from None
    return settings


def _check_jobs(settings: Settings) -> None:
    """Complain of jobs that could not be kept."""
    path = settings.jobs_path
    if settings.jobs_address is not None and settings.jobs_executor != "ray":
        raise ValueError("jobs_address: an address is that of a cluster: jobs_executor must be ray")
    if path is None:
        if settings.jobs_executor != "local":
            raise ValueError("jobs_executor: jobs_path is needed, too: without it there are no jobs")
        if settings.jobs_database is not None:
            raise ValueError("jobs_database: jobs_path is needed, too: bodies and results stand there")
        return
    there = next((each for each in (path, *path.absolute().parents) if each.exists()), path)
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK):
        raise ValueError(f"jobs_path: {path} is no folder in which this user may write")
    if settings.jobs_database is not None and importlib.util.find_spec("psycopg") is None:
        raise ValueError("jobs_database: PostgreSQL needs an extra: pip install 'primfit[postgres]'")
    if settings.jobs_executor == "ray" and importlib.util.find_spec("ray") is None:
        raise ValueError("jobs_executor: Ray needs an extra: pip install 'primfit[ray]'")


def _file(settings_cls: type[BaseSettings]) -> TomlConfigSettingsSource:
    path = os.environ.get(CONFIG) or None
    try:
        if path is not None and not Path(path).is_file():
            raise FileNotFoundError("no such file")
        return TomlConfigSettingsSource(settings_cls, path)
    except OSError as error:
        raise SettingsError(f"{CONFIG}: {path}: {error.strerror or error}") from None
    except ValueError as error:
        raise SettingsError(f"{CONFIG}: {path}: {error}") from None


def _complaint(found: Mapping[str, Any], flags: Mapping[str, Any]) -> str:
    """What pydantic found, with the place where the value stands; a secret value is left out."""
    name = str(found["loc"][0])
    place = f"{os.environ.get(CONFIG)}: {name[:_VALUE_LENGTH]}"
    if found["type"] == "extra_forbidden":
        return f"{place}: unknown setting; known are {', '.join(Settings.model_fields)}"
    if name in flags:
        place = f"--{name.replace('_', '-')}"
    elif (variable := f"{PREFIX}{name.upper()}") in os.environ:
        place = variable
    message = found["msg"].removeprefix("Value error, ")
    value = "" if name in SECRET else f"; it is {str(found['input'])[:_VALUE_LENGTH]!r}"
    return f"{place}: {message[:1].lower()}{message[1:]}{value}"
