"""Loops over points are compiled twice; the one with FMA is there, and used where it can be."""

import platform
import sys
from pathlib import Path

import numpy as np
import pytest

from primfit.fitting.solver._descent import NAMES, distances

CPUINFO = Path("/proc/cpuinfo")


def has_fma() -> bool:
    return CPUINFO.exists() and " fma " in CPUINFO.read_text() and " avx2 " in CPUINFO.read_text()


@pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() != "x86_64" or not has_fma(),
    reason="functions are compiled twice on Linux for x86-64; this processor is another, or has no FMA",
)
def test_a_product_is_not_rounded_before_it_is_added() -> None:
    """v^2 and its rounding differ by 2^-58, which only a fused multiply-add sees."""
    v = 1.0 + 2.0**-29
    row = np.array([v, -v, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    found = distances(NAMES.index("plane"), row, np.tile([v, v, 0.0], (64, 1)))
    np.testing.assert_array_equal(np.abs(found), 2.0**-58)
