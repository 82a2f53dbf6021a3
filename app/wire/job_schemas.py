"""Jobs on the wire, in the words of OGC API Processes (part 1, 18-062r2) where it has words for them."""

from datetime import datetime
from typing import Literal

from pydantic import BaseModel, Field

from .schemas import BatchCounts, Problem

JobState = Literal["accepted", "running", "successful", "failed", "dismissed"]


class Link(BaseModel):
    """Where something else is."""

    href: str = Field(description="relative to the path of the request")
    rel: str
    type: str


class JobStatus(BaseModel):
    """What is known of a job; what is not there does not apply to it."""

    jobID: str = Field(examples=["0b2b7d8e-7f6c-4f0e-9d6a-3c1f5a1e2d4b"])
    processID: Literal["fit_batch"] = Field(description="what is done: that of `POST /fit/batch`")
    type: Literal["process"]
    status: JobState
    message: str = Field(description="the status in words")
    progress: int = Field(ge=0, le=100, description="percent of the files, and of the segments in each")
    created: datetime
    updated: datetime
    started: datetime | None = None
    finished: datetime | None = None
    expires: datetime | None = Field(None, description="when the job and its results are removed")
    queue_place: int | None = Field(
        None,
        description="how many jobs of all clients wait that came no later, this one included; it may be "
        "begun sooner, as the clients with the fewest jobs under way come first",
    )
    files: int
    lines: int = Field(description="lines of results that are there, the summary included")
    summary: BatchCounts | None = None
    problem: Problem | None = Field(None, description="why it failed")
    links: list[Link]


class JobList(BaseModel):
    """The jobs of a client, in the order in which they came."""

    jobs: list[JobStatus]
    links: list[Link]
