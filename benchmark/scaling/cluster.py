"""A Ray cluster of several nodes on this machine, and the loss of one of them."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

STORE = 100 * 2**20
"""Bytes of the object store of each node."""


@contextmanager
def cluster(nodes: int = 3, head_cpus: int = 0) -> Iterator[Any]:
    """A head that has so many processors, and nodes with one each."""
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    from ray.cluster_utils import Cluster

    head = {"num_cpus": head_cpus, "include_dashboard": False, "object_store_memory": STORE}
    made = Cluster(initialize_head=True, head_node_args=head)
    try:
        for _ in range(nodes):
            made.add_node(num_cpus=1, object_store_memory=STORE)
        yield made
    finally:
        made.shutdown()


def kill_node(cluster: Any) -> None:
    """A machine that loses its power: the raylet and all workers of it are killed at once."""
    node = cluster.list_all_nodes()[-1]
    for process in (node.all_processes["raylet"][0].process.pid, *workers_of(node)):
        os.kill(process, signal.SIGKILL)
    cluster.remove_node(node, allow_graceful=False)


def workers_of(node: Any) -> list[int]:
    """The processes that a node has at work."""
    raylet = str(node.all_processes["raylet"][0].process.pid)
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # it has ended
            if stat.read_text().rpartition(")")[2].split()[1] == raylet:
                found.append(int(stat.parent.name))
    return found
