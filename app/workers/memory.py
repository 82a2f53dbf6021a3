"""How much memory the jobs of a worker process may take, and the words for one that wants more."""

import sys
from pathlib import Path

from ..readers.errors import TooLargeError

_SIZES = Path("/proc/self/statm")
_allowed: list[int] = []


def allow(n_bytes: int) -> None:
    """Let this process have so many bytes more than it has now, on systems that keep to that (Linux)."""
    if sys.platform != "linux":
        return
    import resource

    now = int(_SIZES.read_text().split()[0]) * resource.getpagesize()
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    limit = now + n_bytes
    if most != resource.RLIM_INFINITY:
        limit = min(limit, most)
    resource.setrlimit(resource.RLIMIT_AS, (limit, most))
    _allowed[:] = [n_bytes]


def too_large() -> TooLargeError:
    """The complaint about a cloud that there is not memory enough for."""
    limit = f"{_allowed[0] / 2**20:.0f} MiB, the limit of a worker" if _allowed else "the machine has"
    return TooLargeError("body", f"reading and fitting need more memory than {limit}; send fewer points")
