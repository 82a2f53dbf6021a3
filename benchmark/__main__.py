"""`python -m benchmark`: the same as `primfit bench`."""

import sys

from benchmark.command import bench

if __name__ == "__main__":
    sys.exit(bench(program="python -m benchmark"))
