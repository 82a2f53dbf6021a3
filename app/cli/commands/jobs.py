"""`primfit jobs`: the jobs that services keep, for administrators."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from ..status import BAD_INPUT, INTERNAL_ERROR, complain

if TYPE_CHECKING:
    from ...jobs.desk import Desk

jobs = typer.Typer(
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="List, cancel and remove the jobs of services.\n\n"
    "They are those in jobs_path and jobs_database, which are set as for 'primfit serve'.",
)


@jobs.command("list")
def list_jobs() -> None:
    """List all jobs, a line each: id, client, status, percent done, lines, bytes and when it came."""
    from datetime import UTC, datetime

    with _desk() as desk:
        for job in desk.store.listed():
            came = datetime.fromtimestamp(job.created, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
            progress = job.progress
            print(
                f"{job.id}  {job.owner or '-':<12}  {job.status:<10}  {progress.percent:3d}%"
                f"  {progress.lines:6d}  {job.bytes:11d}  {came}"
            )


@jobs.command()
def cancel(ids: Annotated[list[str], typer.Argument(help="Ids of jobs.", metavar="ID...")]) -> None:
    """Cancel jobs; those that have ended are removed."""
    unknown = []
    with _desk() as desk:
        for job_id in ids:
            job = desk.store.find(job_id)
            if job is None:
                unknown.append(job_id)
            else:
                desk.dismiss(job)
    for job_id in unknown:
        complain("jobs", f"{job_id}: no such job")
    if unknown:
        raise typer.Exit(BAD_INPUT)


@jobs.command()
def clean(
    ended: Annotated[
        bool, typer.Option("--ended", help="Remove every job that has ended, however short ago.")
    ] = False,
) -> None:
    """Remove jobs whose time has come, and files that belong to no job."""
    with _desk() as desk:
        n_jobs = desk.clean()
        for job in desk.store.listed() if ended else ():
            if job.ended:
                desk.remove(job.id)
                n_jobs += 1
        n_strays = desk.clear_strays()
        print(f"{n_jobs} jobs removed, and the files of {n_strays} that no record names")


@contextmanager
def _desk() -> Iterator["Desk"]:
    """The jobs by the settings in force."""
    from ...jobs.files import WrongDatabaseError
    from ...jobs.store import told
    from ...service.jobs_kept import open_desk
    from ...service.settings import SettingsError, load
    from ...wire.problems import InsufficientStorageError, JobsUnavailableError

    try:
        settings = load()
    except SettingsError as error:
        for complaint in error.complaints:
            complain("jobs", complaint)
        raise typer.Exit(BAD_INPUT) from None
    if settings.jobs_path is None:
        complain("jobs", "jobs_path is not set (PRIMFIT_JOBS_PATH, or the file that PRIMFIT_CONFIG names)")
        raise typer.Exit(BAD_INPUT)
    if not settings.jobs_path.is_dir():
        complain("jobs", f"{settings.jobs_path}: no such folder (jobs_path)")
        raise typer.Exit(BAD_INPUT)
    desk = open_desk(settings)
    try:
        yield desk
    except WrongDatabaseError as error:
        complain("jobs", str(error))
        raise typer.Exit(BAD_INPUT) from None
    except (JobsUnavailableError, InsufficientStorageError) as error:
        complain("jobs", told(error))
        raise typer.Exit(INTERNAL_ERROR) from None
    finally:
        desk.close()
