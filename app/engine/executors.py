"""Who does the work on many clouds, by the name of an option."""

from typing import Literal

from primfit.fitting.errors import InvalidOptionError

from .ray_team import RayTeam
from .team import Team

Executor = Literal["local", "ray"]
EXECUTORS: tuple[Executor, ...] = ("local", "ray")

AnyTeam = Team | RayTeam
"""Both have the same methods."""


def check_executor(executor: str, address: str | None) -> None:
    """Raises `InvalidOptionError` for one that is unknown, and for an address that nobody asks for."""
    if executor not in EXECUTORS:
        raise InvalidOptionError(f"executor must be one of {', '.join(EXECUTORS)}", "executor")
    if address is not None and executor != "ray":
        raise InvalidOptionError("an address is that of a cluster: it needs the executor ray", "address")


def team_of(
    executor: Executor,
    workers: int | None,
    address: str | None = None,
    *,
    most: int | None = None,
    apart: bool = False,
) -> AnyTeam:
    """Processes of this machine, or of a cluster of Ray.

    Parameters
    ----------
    workers : how many; None for one on this machine, and for each processor of a cluster
    address : of the cluster; see `RayTeam`
    most : chunks that there will be, more processes than which would be idle on this machine
    apart : even a single process of this machine is not this one; see `Team`
    """
    if executor == "ray":
        return RayTeam(workers, address)
    size = workers or 1
    return Team(size if most is None else min(size, most), apart)
