"""The way of a body through primfit without the service: read, fit, written, as a worker of it does.

The one place of the benchmark that imports the app; `pyproject.toml` says so.
"""

from primfit.app import readers
from primfit.app.engine import answer


def written(body: bytes) -> bytes:
    """The answer of `POST /fit` for a body, by default options, as JSON."""
    cloud = readers.read(memoryview(body))
    return answer.to_json(answer.answered(cloud, {})[1])
