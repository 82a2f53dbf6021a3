"""What worker processes do for the tools: read and fit, export, explain, cut a scan and fit its segments."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from itertools import pairwise
from pathlib import Path
from typing import Any, Protocol

from primfit.fitting.answer.summary import summary
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError
from primfit.fitting.names import ANSWER_PARTS, Unit

from ..engine.cut import Label, Stored, cut_cloud, store
from ..engine.fit import prepared
from ..engine.team import chunks
from ..exports import ExportOptions, Fitted, check_parts, check_unit, outcomes
from ..readers import Cloud, Limits, Pick, UnreadableFileError, read
from ..readers.columns import as_columns
from ..wire.options import check_options
from ..workers.batch_jobs import too_many_segments
from ..workers.jobs import fitted
from . import results
from .output import Output


class Source(Protocol):
    """A file with a cloud, and its name where it has one."""

    @property
    def name(self) -> str | None: ...

    def read(self, limit: int) -> bytes:
        """All of it; raises where it holds more bytes, or may not be read."""
        ...


@dataclass(frozen=True, kw_only=True)
class Job:
    """What is asked of a file: the options of a fit that were given beside it, and how much may be read."""

    source: Source
    options: Mapping[str, Any]
    limits: Limits
    request_id: str = "mcp"
    trace_id: str | None = None

    def opened(self, data: bytes, labels: str | None = None) -> tuple[Cloud, dict[str, Any]]:
        """The cloud in a file, and the options that hold for it: a file may have some."""
        cloud = read(data, self.limits, Pick(labels, as_columns(self.options.get("columns"))))
        options = check_options((), self.options, cloud.options)
        return cloud, options

    def read(self) -> bytes:
        return self.source.read(self.limits.unpacked_bytes)

    def fitted(self, artifacts: Sequence[str] = ()) -> tuple[Fitted, dict[str, Any]]:
        """What was recognized, and the answer; nothing is fitted that the artifacts could not be made of."""
        cloud, options = self.opened(self.read())
        cloud = prepared(cloud, options)
        check_parts(artifacts, options.get("include", ANSWER_PARTS))
        check_unit(artifacts, cloud.unit)
        recognition, answer, _ = fitted(cloud, options, self.limits)
        return Fitted(recognition, cloud, options, self.source.name), answer


class FitJob(Job):
    """The answer for a cloud."""

    def work(self) -> dict[str, Any]:
        return results.fit_result(self.fitted()[1])


@dataclass(frozen=True)
class Explained:
    """The figures, the words, and the picture as PNG."""

    figures: dict[str, Any]
    words: str
    picture: bytes


class ExplainJob(Job):
    """The answer for a cloud in words, with a picture."""

    def work(self) -> Explained:
        from .picture import picture

        whole, answer = self.fitted()
        figures = {
            "status": answer["status"],
            "message": answer["message"],
            "kind": answer["primitive"] and answer["primitive"]["kind"],
            "alternatives": [other["kind"] for other in answer["alternatives"]],
            "warnings": list(answer["warnings"]),
            "attempts": results.attempts(answer),
            **_counts(whole),
        }
        return Explained(figures, _words(answer), picture(whole, answer))


def _counts(whole: Fitted) -> dict[str, int | None]:
    if whole.recognition.primitive is None:
        return {"n_inliers": None, "n_outliers": None}
    n_inliers = int(whole.residuals.inlier.sum())
    return {"n_inliers": n_inliers, "n_outliers": len(whole.points) - n_inliers}


def _words(answer: Mapping[str, Any]) -> str:
    """The summary of the command line, and why each kind was accepted or refused."""
    reasons = [f"{each['kind']}: {each['outcome']}. {each['reason']}" for each in answer["attempts"]]
    return "\n".join([summary(answer), "", "Kinds that were tried, in this order:", *reasons])


@dataclass(frozen=True, kw_only=True)
class ExportJob(Job):
    """Files made of the answer for a cloud, written into the folder for them."""

    artifacts: tuple[str, ...]
    how: ExportOptions
    output: Output

    def work(self) -> dict[str, Any]:
        self.output.check(self.artifacts)
        whole, answer = self.fitted(self.artifacts)
        found = outcomes(whole, self.artifacts, self.how)
        made = {name: each for name, each in found.items() if each.content is not None}
        files = [
            {**self.output.write(name, each.content or b""), "warning": each.warning or None}
            for name, each in made.items()
        ]
        return {
            **{name: answer[name] for name in ("status", "message", "primitive")},
            "files": files,
            "problems": [
                {"artifact": name, "problem": each.problem}
                for name, each in found.items()
                if name not in made
            ],
        }


@dataclass(frozen=True)
class Scan:
    """A scan that was cut: its segments lie between the `bounds` of its points in a file."""

    labels: list[Label]
    bounds: list[int]
    stored: Stored
    options: Mapping[str, Any]
    unit: Unit | None
    sha256: str

    def chunks(self, n_workers: int) -> list[list[tuple[Label, int, int]]]:
        """The segments in pieces that are worth handing out: of each its label and its rows."""
        segments = [(label, *rows) for label, rows in zip(self.labels, pairwise(self.bounds), strict=True)]
        sizes = [stop - start for _, start, stop in segments]
        return [list(chunk) for chunk in chunks(segments, sizes, n_workers)]


@dataclass(frozen=True, kw_only=True)
class CutJob(Job):
    """A scan cut into its segments, whose points are kept in the file `scratch`."""

    labels: str
    scratch: Path
    most: int

    def work(self) -> Scan:
        data = self.read()
        cloud, options = self.opened(data, self.labels)
        cut = cut_cloud(cloud)
        if cut is None:
            raise UnreadableFileError(
                "labels",
                "no column has a usual name of labels; say in `labels` which one tells segments apart",
            )
        if len(cut.labels) > self.most:
            raise too_many_segments(len(cut.labels), self.most)
        with self.scratch.open("r+b") as file:
            stored = store(cut, self.scratch, file)
        unit = options.get("unit") or cloud.unit
        return Scan(cut.labels, cut.bounds, stored, options, unit, sha256(data).hexdigest())


@dataclass(frozen=True)
class RowsJob:
    """Some segments of a scan that was cut, a row for each."""

    stored: Stored
    options: Mapping[str, Any]
    limits: Limits
    segments: Sequence[tuple[Label, int, int]]
    request_id: str = "mcp"
    trace_id: str | None = field(default=None)

    def work(self) -> list[dict[str, Any]]:
        return [self._row(*segment) for segment in self.segments]

    def _row(self, label: Label, start: int, stop: int) -> dict[str, Any]:
        try:
            cloud = prepared(self.stored.segment(start, stop), self.options)
            return results.row(label, fitted(cloud, self.options, self.limits)[1])
        except (InvalidPointCloudError, InvalidOptionError, UnreadableFileError) as error:
            return {"label": results.shown(label), "n_points": stop - start, "problem": str(error)}
