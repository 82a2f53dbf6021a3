"""`primfit paper METHOD FILE...`: what a method of the paper answers, read and printed as `primfit fit` does.

The one place of this part that imports the app; `pyproject.toml` says so.
"""

import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from primfit.app.cli.files import Problem, answer_file
from primfit.app.cli.render import show
from primfit.app.cli.status import EXIT, complain, worst
from primfit.app.engine import answer as engine
from primfit.app.engine.fit import prepared
from primfit.app.readers import Cloud
from primfit.app.readers.missing import warnings_of
from primfit.fitting.answer.result import Recognition
from primfit.models.weights import WeightsMismatchError

from .answer import receipt, recognition
from .method import Method, load


class CannotRunError(RuntimeError):
    """What a method is made of is not there."""


def paper(name: str, files: Sequence[str], options: Mapping[str, Any], as_json: bool) -> int:
    """Answer for each file by the method of that name; returns the exit status, the worst of the files.

    Raises
    ------
    CannotRunError : with what to do about it
    """
    method = loaded(name)
    return worst(_statuses(method, files, options, as_json))


def loaded(name: str) -> Method:
    """The method, ready to be asked."""
    try:
        return load(name)
    except ImportError as error:
        raise CannotRunError(f"{name}: {error}; pip install --editable '.[train]' brings it") from None
    except WeightsMismatchError as error:
        raise CannotRunError(f"{error}; 'make weights-paper' trains them") from None


def _statuses(
    method: Method, files: Sequence[str], options: Mapping[str, Any], as_json: bool
) -> Iterator[int]:
    """The exit status of each answer, which is written before the next one is made."""

    def answered(cloud: Cloud, used: Mapping[str, Any]) -> tuple[Recognition, dict[str, Any]]:
        return asked(method, prepared(cloud, used), used)

    for name in files:
        found = answer_file(name, options, answered)
        if isinstance(found, Problem):
            complain(found.name, found.message)
            yield found.exit_status
            continue
        _, body = found
        if as_json:
            sys.stdout.buffer.write(engine.to_json(body) + b"\n")
            sys.stdout.flush()
        else:
            show(name, body)
        yield EXIT[body["status"]]


def asked(method: Method, cloud: Cloud, options: Mapping[str, Any]) -> tuple[Recognition, dict[str, Any]]:
    """What a method recognizes in a cloud, and the body of its answer."""
    found = recognition(method.fit(cloud.points), cloud.points, cloud.unit)
    kept = engine.receipt(cloud, {"classifier": "none"})
    body = {**found.to_dict(), "warnings": warnings_of(cloud), "receipt": receipt(kept, method)}
    return found, body
