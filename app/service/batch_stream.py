"""A batch as it is answered: the jobs of its items in turns, and their lines in the order of the input."""

from collections import Counter
from collections.abc import AsyncGenerator, Awaitable, Callable, Sequence
from contextlib import AsyncExitStack, aclosing, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import orjson
from starlette.requests import ClientDisconnect
from starlette.responses import StreamingResponse
from starlette.types import Receive, Scope, Send

from ..engine.items import Item, Told
from ..engine.names import Ids, base_name
from ..wire.multipart import Part
from ..wire.problems import InsufficientStorageError, ServiceError, problem
from ..workers.batch_jobs import CutFile, FileJob, Found, Opened, SegmentJob, Stretch, too_many_segments
from ..workers.jobs import Reply
from .body import is_large
from .media_types import NDJSON
from .metrics import Metrics
from .ordered import in_order
from .settings import Settings

_AHEAD = 8
"""Items, for each worker, that may be done before their turn to be sent has come."""
_BYTES_A_POINT = 3 * 8


class NotAgainError(Exception):
    """A file of which lines were told before cannot be read again."""


class Scratch(Protocol):
    """A temporary file that is removed when it is closed."""

    name: str

    def close(self) -> None: ...


Result = tuple[Item, Told, Found | Reply, Scratch | None]
"""An item, where it stands, and what came of it; the file with its points, where no later item needs it."""


@dataclass
class Batch:
    """A batch that is opened, and what it needs to be answered; the counts of its items join its `facts`.

    So many `workers` do what `run` is given. Where its first lines were `told` before, it goes on behind
    them.
    """

    request_id: str
    body: bytes | Path
    media_type: str
    opened: Opened
    settings: Settings
    scratch: Callable[[], Scratch]
    run: Callable[..., Awaitable[Any]]
    workers: int
    metrics: Metrics
    facts: dict[str, Any]
    told: Sequence[Told] = ()

    async def lines(self) -> AsyncGenerator[bytes, None]:
        """A line for each item, in the order of the input, and the summary that says that it is complete."""
        async with aclosing(self.told_lines()) as lines:
            async for _, line in lines:
                yield line

    async def told_lines(self) -> AsyncGenerator[tuple[Told | None, bytes], None]:
        """The same lines with what each is about; the summary, which is about none, counts all of them."""
        counts = Counter(told.outcome for told in self.told)
        async with aclosing(in_order(self._items(), _AHEAD * self.workers)) as results:
            async for item, place, result, done_with in results:
                self.metrics.answered(result.facts)
                told = replace(place, outcome=result.facts.get("fit_status", "problems"))
                counts[told.outcome] += 1
                yield told, item.line("answer" if isinstance(result, Found) else "problem", result.content)
                if done_with is not None:
                    done_with.close()
        summary = {name: counts[name] for name in ("fitted", "ambiguous", "no_fit", "problems")}
        summary = {"items": counts.total(), **summary}
        self.facts |= summary
        yield None, orjson.dumps({"summary": summary}) + b"\n"

    async def _items(self) -> AsyncGenerator[Callable[[], Awaitable[Result]], None]:
        """The work of each item. A file without labels is done when it is read; the others are cut only."""
        number, n_begun = _files_told(self.told)
        ids = self._ids_of_files(number)
        left = self.settings.max_batch_items - len(self.opened.files)
        left -= sum(told.of - 1 for told in self.told if told.file <= number and told.index == 0)
        async with aclosing(in_order(self._reads(number), self.workers + 1)) as reads:
            async for part, scratch, read in reads:
                number += 1
                whole = Item.of_file(base_name(part.filename), number, ids)
                if isinstance(read, CutFile) and len(read.labels) - 1 > left:
                    read = self._problem(too_many_segments(len(read.labels), left + 1))
                if not isinstance(read, CutFile):
                    if n_begun:
                        raise NotAgainError(f"file {number} was cut once, and not again")
                    if scratch is not None:
                        scratch.close()
                    yield partial(_at_hand, (whole, Told(number, 0, 1, "", None), read, None))
                    continue
                n_items = len(read.labels)
                left -= n_items - 1
                for i, label in enumerate(read.labels):
                    item = whole.segment(label, ids)
                    if i < n_begun:
                        continue
                    start, stop = read.bounds[i : i + 2]
                    job = SegmentJob(
                        self.request_id, read.stored, read.options, self.settings.limits, start, stop
                    )
                    done_with = scratch if i == n_items - 1 else None
                    yield partial(self._fit, item, Told(number, i, n_items, "", label), job, done_with)
                n_begun = 0

    def _ids_of_files(self, n_files: int) -> Ids:
        """The ids that the first files, and their segments, have got: those to come are others."""
        ids = Ids()
        whole = None
        for told in self.told:
            if told.file > n_files:
                break
            if told.index == 0:
                name = base_name(self.opened.files[told.file - 1].filename)
                whole = Item.of_file(name, told.file, ids)
            if whole is not None and told.label is not None:
                whole.segment(told.label, ids)
        return ids

    async def _reads(
        self, first: int
    ) -> AsyncGenerator[Callable[[], Awaitable[tuple[Part, Scratch | None, Any]]], None]:
        for part in self.opened.files[first:]:
            yield partial(self._read, part)

    async def _read(self, part: Part) -> tuple[Part, Scratch | None, CutFile | Found | Reply]:
        settings = self.settings
        try:
            scratch = self.scratch()
        except InsufficientStorageError as error:
            return part, None, self._problem(error)
        content: bytes | Stretch
        if isinstance(self.body, bytes):
            content = self.body[part.start : part.stop]
        else:
            content = Stretch(self.body, part.start, part.stop)
        job = FileJob(
            self.request_id,
            content,
            self.media_type,
            self.opened.unpacked,
            self.opened.labels,
            self.opened.options,
            settings.limits,
            Path(scratch.name),
            settings.max_batch_items,
        )
        return part, scratch, await self._result(job, part.stop - part.start)

    async def _fit(self, item: Item, place: Told, job: SegmentJob, done_with: Scratch | None) -> Result:
        n_bytes = (job.stop - job.start) * _BYTES_A_POINT
        return item, place, await self._result(job, n_bytes), done_with

    async def _result(self, job: FileJob | SegmentJob, n_bytes: int) -> Any:
        """What a job results in; a lost worker or the time limit is a problem of this job alone."""
        try:
            result = await self.run(job, heavy=is_large(n_bytes))
        except ServiceError as error:
            return self._problem(error)
        if result is None:
            raise ClientDisconnect
        return result

    def _problem(self, error: Exception) -> Reply:
        made = problem(error, f"/requests/{self.request_id}")
        return Reply(made.status, made.content, facts={"problem": made.slug})


def _files_told(told: Sequence[Told]) -> tuple[int, int]:
    """How many files are wholly told, and how many items of the next one."""
    if not told:
        return 0, 0
    last = told[-1]
    return (last.file, 0) if last.index == last.of - 1 else (last.file - 1, last.index + 1)


async def _at_hand(result: Result) -> Result:
    return result


class Lines(StreamingResponse):
    """Lines that are made while they are sent; when they end, as it may be, what they need is given back."""

    media_type = NDJSON

    def __init__(self, lines: AsyncGenerator[bytes, None], resources: AsyncExitStack) -> None:
        super().__init__(lines)
        resources.push_async_callback(lines.aclose)
        self._resources = resources

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async with self._resources:
            with suppress(ClientDisconnect):
                await super().__call__(scope, receive, send)
