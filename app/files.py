"""The answer for a file on disk or on standard input: what the command line asks of the engine."""

import signal
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from app.answer import answer
from app.engine import fit_cloud
from app.readers import Cloud, UnreadableFileError, read
from fitting.errors import InvalidOptionError, InvalidPointCloudError
from fitting.result import Recognition

STDIN = "-"


@dataclass(frozen=True)
class Problem:
    """Why a file has no answer; `exit_status` is 2 for bad input, 1 where primfit itself failed."""

    name: str
    message: str
    exit_status: int = 2


def answer_file(name: str, options: Mapping[str, Any]) -> dict[str, Any] | Problem:
    """The body of `POST /fit` for a file, or what is wrong with it.

    `options` are those of `engine.fit` that were given beside the file.
    """
    found = fit_file(name, options)
    return found if isinstance(found, Problem) else found[1]


def fit_file(name: str, options: Mapping[str, Any]) -> tuple[Recognition, dict[str, Any]] | Problem:
    """What was recognised in a file and the body of `POST /fit` for it, or what is wrong with it."""
    try:
        data = sys.stdin.buffer.read() if name == STDIN else Path(name).read_bytes()
        cloud = read(data)
        used = _with_options_of(cloud, options)
        recognition = fit_cloud(cloud, used)
        return recognition, answer(recognition, cloud, used)
    except OSError as error:
        return Problem(name, error.strerror or str(error))
    except UnreadableFileError as error:
        return Problem(name, f"{error.field}: {error.message}")
    except (InvalidPointCloudError, InvalidOptionError) as error:
        return Problem(name, str(error))
    except Exception as error:  # one file must not cost the others their answers
        return Problem(name, f"internal error, please report it: {error!r}", exit_status=1)


def _with_options_of(cloud: Cloud, given: Mapping[str, Any]) -> dict[str, Any]:
    """The options given, and those in the file: JSON may hold some, as the body of `POST /fit` does."""
    if not cloud.options:
        return dict(given)
    # Imported here, because few files hold options and the check brings half of the service along.
    from app.options import check_options
    from app.problems import InvalidOptionsError

    try:
        return check_options((), given, cloud.options)
    except InvalidOptionsError as error:
        bad = error.errors[0]
        raise UnreadableFileError(bad.field, bad.message) from None


def answer_files(
    names: Sequence[str], options: Mapping[str, Any], workers: int
) -> Iterator[dict[str, Any] | Problem]:
    """The answers of many files, in their order; how many processes share the work changes nothing else."""
    answer_one = partial(answer_file, options=dict(options))
    if min(workers, len(names)) <= 1:
        yield from map(answer_one, names)
        return
    with ProcessPoolExecutor(min(workers, len(names)), mp_context=get_context("spawn")) as pool:
        with _interrupts_ignored():
            answers = pool.map(answer_one, names)
        try:
            yield from answers
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Processes started here never see Ctrl-C, which a terminal sends to all: this process stops them."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
