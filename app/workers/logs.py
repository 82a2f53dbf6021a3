"""The log: one line an event, for people or as JSON, with the ids of its request and its trace."""

import logging
import logging.config
import time
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

import orjson

from .request_id import REQUEST_ID
from .trace_context import TRACE_ID

DOOR = "primfit.door"
"""The logger of what clients can cause as often as they like; like asyncio's, it does not repeat itself."""
_QUIET_SECONDS = 60.0
_MOST_MESSAGES = 100
"""Messages to remember; asyncio's may name objects, so that no two are the same."""


def configure(form: str) -> None:
    """Write to standard error as `text` or `json`: our events, the server's, and warnings of others."""
    # No line tells them; each request has one, and refusals come thick and fast.
    logging.logThreads = logging.logProcesses = logging.logMultiprocessing = False
    logging.config.dictConfig(
        {
            "version": 1,
            "disable_existing_loggers": False,
            "formatters": {"text": {"()": _Text}, "json": {"()": _Json}},
            "handlers": {"stderr": {"class": "logging.StreamHandler", "formatter": form}},
            "filters": {"once": {"()": Once}},
            "root": {"level": "WARNING", "handlers": ["stderr"]},
            "loggers": {
                **{name: {"level": "INFO"} for name in ("primfit", "uvicorn")},
                **{name: {"filters": ["once"]} for name in (DOOR, "asyncio")},
            },
        }
    )


def event(logger: logging.Logger, level: int, message: str, facts: Mapping[str, Any]) -> None:
    """Log a message with facts, which stand beside it under their names."""
    logger.log(level, message, extra={"facts": facts})


class Once(logging.Filter):
    """Lets each message through once a minute; the next one says how many were left out meanwhile."""

    def __init__(self) -> None:
        super().__init__()
        self._last: dict[str, tuple[float, int]] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether it is told. Messages are told apart before their arguments and facts are put in."""
        now = time.monotonic()
        told, left_out = self._last.get(record.msg, (now - _QUIET_SECONDS, 0))
        if now - told < _QUIET_SECONDS:
            self._last[record.msg] = told, left_out + 1
            return False
        if left_out:
            record.facts = {**getattr(record, "facts", {}), "left_out": left_out}
        if len(self._last) >= _MOST_MESSAGES:
            self._last.clear()
        self._last[record.msg] = now, 0
        return True


class _Text(logging.Formatter):
    """`2026-03-01T12:00:00.000Z INFO message name=value ...`, and a traceback below where there is one."""

    def format(self, record: logging.LogRecord) -> str:
        facts = "".join(f" {name}={_shown(value)}" for name, value in _facts(record).items())
        line = f"{_time(record)} {record.levelname} {record.getMessage().rstrip()}{facts}"
        return line if record.exc_info is None else f"{line}\n{self.formatException(record.exc_info)}"


class _Json(logging.Formatter):
    """An object a line; a traceback is its member `exception`."""

    def format(self, record: logging.LogRecord) -> str:
        line = {"time": _time(record), "level": record.levelname.lower()}
        line |= {"message": record.getMessage().rstrip(), **_facts(record)}
        if record.exc_info is not None:
            line["exception"] = self.formatException(record.exc_info)
        return orjson.dumps(line, default=str).decode()


def _shown(value: object) -> str:
    text = str(value)
    return repr(text) if " " in text or not text else text


def _time(record: logging.LogRecord) -> str:
    return datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds")[:-6] + "Z"


def _facts(record: logging.LogRecord) -> dict[str, Any]:
    """What is known beside the message; unknown facts are left out."""
    facts = {"request_id": REQUEST_ID.get(), "trace_id": TRACE_ID.get(), **getattr(record, "facts", {})}
    return {name: value for name, value in facts.items() if value is not None}
