"""`python -m primfit.benchmark`: the same as `primfit bench`."""

import sys

from .command import bench

if __name__ == "__main__":
    sys.exit(bench(program="python -m primfit.benchmark"))
