"""What a segment costs by its number of points: a line through processor times of whole ways to an answer.

    python -m primfit.benchmark.speed.cost [N]

prints the constants of `app/bulk/tasks.py`, from N scanned clouds of 50 to 3,000 points (400).
"""

import sys
import time
from dataclasses import replace

import numpy as np
import orjson

from primfit.synthetic import SyntheticCloud, clouds
from primfit.synthetic.recipes import Range, ScannerRecipe

from .asked import written

N = 400
POINTS = Range(50, 3000)


def measured(n: int) -> tuple[float, float]:
    """Seconds a segment, and seconds a point, of least squares over n clouds."""
    written(_body(next(iter(clouds(ScannerRecipe(), 1)))))  # loads the weights
    recipe = replace(ScannerRecipe(), seed=1, points=POINTS)
    times = np.array([(len(cloud.points), _seconds(_body(cloud))) for cloud in clouds(recipe, n)])
    line, *_ = np.linalg.lstsq(np.stack([np.ones(n), times[:, 0]], axis=1), times[:, 1])
    return float(line[0]), float(line[1])


def _body(cloud: SyntheticCloud) -> bytes:
    return orjson.dumps({"points": cloud.points}, option=orjson.OPT_SERIALIZE_NUMPY)


def _seconds(body: bytes) -> float:
    before = time.process_time()
    written(body)
    return time.process_time() - before


if __name__ == "__main__":
    a, b = measured(int(sys.argv[1]) if len(sys.argv) > 1 else N)
    print(f"{a:.2g} s a segment and {b:.2g} s a point")
