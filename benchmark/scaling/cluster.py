"""A Ray cluster of several nodes on this machine, and the loss of one of them."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

STORE = 100 * 2**20
"""Bytes of the object store of each node."""


@contextmanager
def cluster(nodes: int = 3) -> Iterator[Any]:
    """A head that works on nothing, and so many nodes with one processor each."""
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    from ray.cluster_utils import Cluster

    head = {"num_cpus": 0, "include_dashboard": False, "object_store_memory": STORE}
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
    raylet = node.all_processes["raylet"][0].process.pid
    for process in (raylet, *_children(raylet)):
        os.kill(process, signal.SIGKILL)
    cluster.remove_node(node, allow_graceful=False)


def _children(parent: int) -> list[int]:
    return [
        int(stat.parent.name)
        for stat in Path("/proc").glob("[0-9]*/stat")
        if stat.read_text().rpartition(")")[2].split()[1] == str(parent)
    ]
