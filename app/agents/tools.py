"""The tools: they find the file, hand the work to a process, and say what came of it, or what is wrong."""

import asyncio
import os
from collections import Counter, OrderedDict
from collections.abc import Awaitable, Callable, Collection, Mapping
from dataclasses import dataclass, field
from inspect import cleandoc
from pathlib import Path
from typing import Annotated, Any, TypeVar

import orjson
from mcp.server.mcpserver import Context, Image, MCPServer
from mcp.server.mcpserver.exceptions import ToolError, UnexpectedToolError
from mcp_types import CallToolResult, InputRequiredResult, TextContent, ToolAnnotations
from pydantic import Field, ValidationError, WithJsonSchema

from ..readers.columns import AUTO_LABELS
from ..readers.errors import FieldError
from ..service.body import is_large
from ..service.settings import Settings
from ..service.spool import Spool
from ..wire.problems import INTERNAL, InvalidOptionsError, NoSuchTicketError, ServiceError, problem
from ..workers.jobs import Reply
from ..workers.pool import WorkerPool
from . import options as of
from . import results
from .output import Output, name_of
from .roots import PathRefusedError, Rooted, Roots
from .tickets import SECONDS, Tickets, Uploaded
from .work import CutJob, ExplainJob, ExportJob, FitJob, RowsJob, Scan

MOST_ROWS = 200
"""Of a page of segments."""

KEPT_SCANS = 4
"""Scans whose rows are kept, so that the next page is not fitted again."""

_REFUSED = (ServiceError, ValueError, OSError)
Result = TypeVar("Result", bound=CallToolResult | InputRequiredResult)

Path_ = Annotated[
    str | None,
    Field(description="file with the cloud: absolute, or relative to a root; never its contents"),
]
Ticket_ = Annotated[
    str | None, Field(description="in place of a path: of a file that was uploaded (HTTP only)")
]
Options_ = Annotated[dict[str, Any] | None, WithJsonSchema(of.fit_schema())]
ExportOptions_ = Annotated[dict[str, Any] | None, WithJsonSchema(of.export_schema())]


class _RefusedError(Exception):
    """A problem document that a process made."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        super().__init__(document["detail"])
        self.document = document


@dataclass
class Tools:
    """All of them, and what they work with.

    Attributes
    ----------
    pool : processes that read and fit
    roots : folders that paths may lead into
    output : the folder for exports; None where none are written
    tickets : of uploads; None on stdio, where there are none
    spool : temporary files
    """

    settings: Settings
    pool: WorkerPool
    roots: Roots
    spool: Spool
    output: Path | None = None
    tickets: Tickets | None = None
    _scans: "OrderedDict[bytes, Rows]" = field(default_factory=OrderedDict)

    def add_to(self, server: MCPServer[Any]) -> None:
        """Have the server offer them."""
        reads = ToolAnnotations(read_only_hint=True, open_world_hint=False)
        writes = ToolAnnotations(read_only_hint=False, destructive_hint=True, open_world_hint=False)
        offered: dict[Callable[..., Any], ToolAnnotations] = {
            self.fit: reads,
            self.fit_segments: reads,
            self.explain: reads,
            self.export: writes,
        }
        if self.tickets is not None:
            offered[self.upload] = ToolAnnotations(read_only_hint=False, open_world_hint=False)
        for tool, hints in offered.items():
            server.add_tool(tool, description=cleandoc(tool.__doc__ or ""), annotations=hints)

    async def fit(
        self, path: Path_ = None, ticket: Ticket_ = None, options: Options_ = None
    ) -> Annotated[CallToolResult, results.Fit]:
        """Say which primitive a cloud is: plane, sphere, cylinder, cone or torus, with its parameters.

        `status` is fitted, ambiguous (several kinds explain it about as well) or no_fit (nothing does; the
        best try is still given). Lengths are in the unit of the file, angles in radians.
        """

        async def answer() -> CallToolResult:
            return _told(await self._done(FitJob, path, ticket, of.checked(options)))

        return await _or_problem(answer)

    async def explain(
        self, path: Path_ = None, ticket: Ticket_ = None, options: Options_ = None
    ) -> Annotated[CallToolResult, results.Explanation]:
        """Fit a cloud and explain the answer: words, why each kind was accepted or refused, and a picture.

        The picture (PNG, 640 x 480) has the points colored by their signed distance, outliers as rings, and
        the trimmed primitive.
        """

        async def answer() -> CallToolResult:
            found = await self._done(ExplainJob, path, ticket, of.checked(options))
            picture = Image(data=found.picture, format="png").to_image_content()
            return CallToolResult(
                content=[TextContent(type="text", text=found.words), picture],
                structured_content=found.figures,
            )

        return await _or_problem(answer)

    async def export(
        self,
        artifacts: Annotated[list[str], Field(description=f"some of {', '.join(of.FORMATS)}")],
        path: Path_ = None,
        ticket: Ticket_ = None,
        options: ExportOptions_ = None,
        name: Annotated[
            str | None, Field(description="what file names begin with; by default the cloud's")
        ] = None,
        overwrite: Annotated[bool, Field(description="replace files of the same names")] = False,
    ) -> Annotated[CallToolResult, results.Export]:
        """Fit a cloud and write files: the trimmed primitive for CAD or as a mesh, residuals, a report.

        They go into the folder that the server was given for them, as NAME-primitive.step and so on.
        """

        async def answer() -> CallToolResult:
            if self.output is None:
                raise _mistake(
                    "artifacts", "this server writes no files: it was started without --output DIR"
                )
            given, how = of.split(options)
            source = await self._source(path, ticket)
            here = source.path if isinstance(source, Rooted) else None
            output = Output(self.output, name_of(name, source.name), os.getpid(), overwrite, here)
            beside = {"artifacts": of.check_artifacts(artifacts), "how": how, "output": output}
            return _told(await self._done(ExportJob, path, ticket, given, **beside))

        return await _or_problem(answer)

    async def fit_segments(
        self,
        context: Context[Any, Any],
        path: Path_ = None,
        ticket: Ticket_ = None,
        labels: Annotated[
            str, Field(description="the column that tells segments apart; auto finds one of a usual name")
        ] = AUTO_LABELS,
        options: Options_ = None,
        offset: Annotated[int, Field(ge=0, description="rows to leave out")] = 0,
        limit: Annotated[int, Field(ge=1, le=MOST_ROWS, description="most rows of the page")] = 50,
    ) -> Annotated[CallToolResult, results.Segments]:
        """Fit each segment of a scan whose points have labels: a row for each, and how many of each kind.

        Rows come in pages, by label: ask again with `offset` set to `next_offset` for more. All segments are
        fitted with the first page, the next ones are quick.
        """

        async def answer() -> CallToolResult:
            rows = await self._rows(context, path, ticket, labels, of.checked(options))
            return _told(rows.page(offset, limit))

        return await _or_problem(answer)

    async def upload(self, context: Context[Any, Any]) -> Annotated[CallToolResult, results.Ticket]:
        """Get a ticket for a file that the server cannot read by a path, and the URL to send it to by PUT."""

        async def answer() -> CallToolResult:
            assert self.tickets is not None
            ticket = self.tickets.new()
            request = context.request_context.request
            assert request is not None
            url = f"{str(request.base_url).rstrip('/')}/uploads/{ticket}"
            return _told(
                {
                    "ticket": ticket,
                    "url": url,
                    "command": f"curl -sS --fail-with-body -T FILE {url}",
                    "max_bytes": self.settings.max_body_bytes,
                    "expires_in_seconds": SECONDS,
                }
            )

        return await _or_problem(answer)

    async def _source(self, path: str | None, ticket: str | None) -> Rooted | Uploaded:
        """The file that is meant; raises where it is not given once, or may not be read."""
        if (path is None) == (ticket is None):
            raise _mistake("path", "give either a path or a ticket")
        if ticket is not None:
            if self.tickets is None:
                raise _mistake("ticket", "tickets are for servers over HTTP; give a path")
            return self.tickets.find(ticket)
        assert path is not None
        return await asyncio.to_thread(self.roots.find, path)

    async def _done(
        self,
        job: Callable[..., Any],
        path: str | None,
        ticket: str | None,
        options: Mapping[str, Any],
        **more: Any,
    ) -> Any:
        """What a job about a file results in."""
        source = await self._source(path, ticket)
        limits = self.settings.limits
        asked = job(source=source, options=options, limits=limits, **more)
        return _result(
            await self.pool.run(asked, _never, large=is_large(await asyncio.to_thread(_size, source)))
        )

    async def _rows(
        self,
        context: Context[Any, Any],
        path: str | None,
        ticket: str | None,
        labels: str,
        options: dict[str, Any],
    ) -> "Rows":
        """The rows of a scan: those that are kept, or of segments that are fitted now."""
        with self.spool.file() as scratch:
            about = {"labels": labels, "scratch": Path(scratch.name), "most": self.settings.max_batch_items}
            scan: Scan = await self._done(CutJob, path, ticket, options, **about)
            key = orjson.dumps([scan.sha256, labels, options], option=orjson.OPT_SORT_KEYS)
            if key not in self._scans:
                self._scans[key] = Rows(await self._fitted(context, scan), scan.unit)
        self._scans.move_to_end(key)
        while len(self._scans) > KEPT_SCANS:
            self._scans.popitem(last=False)
        return self._scans[key]

    async def _fitted(self, context: Context[Any, Any], scan: Scan) -> list[dict[str, Any]]:
        """A row for each segment; processes share them, and the client is told how far they are."""
        chunks, limits = scan.chunks(self.settings.workers), self.settings.limits
        n_done = 0

        async def done(chunk: list[tuple[Any, int, int]]) -> list[dict[str, Any]]:
            nonlocal n_done
            rows = await _rows_of(run, RowsJob(scan.stored, scan.options, limits, chunk))
            n_done += len(rows)
            await context.report_progress(
                n_done, len(scan.labels), f"{n_done} of {len(scan.labels)} segments"
            )
            return rows

        with self.pool.batch() as run:
            async with asyncio.TaskGroup() as group:
                tasks = [group.create_task(done(chunk)) for chunk in chunks]
        return [row for task in tasks for row in task.result()]


async def _rows_of(run: Callable[..., Awaitable[Any]], job: RowsJob) -> list[dict[str, Any]]:
    """The rows of some segments; where the process was lost, or the time was over, that is their problem."""
    try:
        return list(_result(await run(job, _never)))
    except (_RefusedError, ServiceError) as error:
        return [
            {"label": results.shown(label), "n_points": stop - start, "problem": str(error)}
            for label, start, stop in job.segments
        ]


@dataclass(frozen=True)
class Rows:
    """The rows of all segments of a scan."""

    rows: list[dict[str, Any]]
    unit: str | None

    def page(self, offset: int, limit: int) -> dict[str, Any]:
        """What `Segments` holds of so many rows."""
        counts = Counter(_sort(row) for row in self.rows)
        after = offset + limit
        return {
            "n_segments": len(self.rows),
            "counts": dict(counts.most_common()),
            "unit": self.unit,
            "offset": offset,
            "rows": self.rows[offset:after],
            "next_offset": after if after < len(self.rows) else None,
        }


def _sort(row: Mapping[str, Any]) -> str:
    if "problem" in row:
        return "problem"
    return row["kind"] if row["status"] == "fitted" else row["status"]


def _size(source: Rooted | Uploaded) -> int:
    """Bytes of a file, 0 where that is not known: only the order of the work hangs on it."""
    try:
        content = source.path if isinstance(source, Rooted) else source.content
        return len(content) if isinstance(content, bytes) else content.stat().st_size
    except OSError:
        return 0


async def _never() -> bool:
    """Whether the client has left: a call that is given up is cancelled."""
    return False


def _result(found: Any) -> Any:
    """What a process made; raises the problem that it found."""
    if found is None:
        raise NoSuchTicketError("the file of this ticket is gone; upload it again")
    if isinstance(found, Reply):
        raise _RefusedError(orjson.loads(found.content))
    return found


def _mistake(field: str, why: str) -> InvalidOptionsError:
    return InvalidOptionsError([FieldError(field, why)])


def _told(content: dict[str, Any]) -> CallToolResult:
    """Structured, and the same as text for clients that show only that."""
    text = orjson.dumps(content).decode()
    return CallToolResult(content=[TextContent(type="text", text=text)], structured_content=content)


async def called(
    call: Callable[[], Awaitable[Result]], given: Collection[str], known: Collection[str] | None
) -> Result | CallToolResult:
    """What a call of a tool results in; a problem where an argument is not `known`, or of a wrong type."""

    async def answer() -> Result:
        if known is not None and (others := [name for name in given if name not in known]):
            why = f"unknown argument; allowed are {', '.join(known)}"
            raise InvalidOptionsError([FieldError(name, why) for name in others])
        try:
            return await call()
        except ToolError as error:
            if not isinstance(error.__cause__, ValidationError) or isinstance(error, UnexpectedToolError):
                raise
            mistakes = error.__cause__.errors()
        raise InvalidOptionsError(
            [FieldError(".".join(map(str, each["loc"])), each["msg"]) for each in mistakes]
        )

    return await _or_problem(answer)


async def _or_problem(answer: Callable[[], Awaitable[Result]]) -> Result | CallToolResult:
    """The answer of a tool, or what the service would say is wrong, in words and as a problem document."""
    try:
        return await answer()
    except _RefusedError as error:
        document = dict(error.document)
    except PathRefusedError as error:
        document = orjson.loads(problem(error, "/mcp").content) | _unmasked(error)
    except _REFUSED as error:
        document = orjson.loads(problem(error, "/mcp").content)
        if document["status"] == INTERNAL.status:
            raise
    document.pop("instance", None)
    return CallToolResult(
        content=[TextContent(type="text", text=_words(document))], structured_content=document, is_error=True
    )


def _unmasked(error: PathRefusedError) -> dict[str, Any]:
    """What names the path in its own letters, which problem documents do not."""
    detail = "".join(letter if letter.isprintable() else "?" for letter in str(error)[:1000])
    return {"detail": detail, "errors": [{"field": "path", "message": detail}]}


def _words(document: Mapping[str, Any]) -> str:
    """A title, the detail where the fields do not hold it, and the fields."""
    detail, errors = document["detail"], document["errors"]
    fields = [f"{each['field']}: {each['message']}{_given(each)}" for each in errors]
    told = len(errors) == 1 and detail.endswith(errors[0]["message"])
    return "\n".join([f"{document['title']}.", *([] if told else [detail]), *fields])


def _given(error: Mapping[str, str]) -> str:
    return f" (given: {error['value']})" if "value" in error else ""
