"""What is compiled: each .pyx, translated by Cython. All else stands in pyproject.toml.

The modules keep to the limited API of Python 3.11, so that one wheel does for it and all later versions.
"""

import os
import sys
from pathlib import Path

from setuptools import Extension, setup

if Path("src/primfit/fitting").is_file():
    sys.exit(
        "src/primfit holds symbolic links (fitting -> ../../fitting, ...), and in this copy of the sources"
        " plain files stand in their place. Clone it again with `git clone --config core.symlinks=true` (on"
        " Windows in developer mode), or install a wheel or the sdist, which hold no links."
    )

FITTING = Path("src/primfit/fitting")
SOURCES = sorted([*FITTING.glob("*/*.pyx"), *Path("src/primfit/models").glob("*.pyx")])
SHARED = sorted(map(str, [*FITTING.glob("*/*.h"), *FITTING.glob("*/*.pxd")]))


def compiled(source: Path) -> Extension:
    """The module of this source."""
    return Extension(
        ".".join(source.with_suffix("").parts[1:]),
        [str(source)],
        depends=SHARED,
        include_dirs=[str(FITTING)],
        define_macros=[("Py_LIMITED_API", "0x030B0000")],
        py_limited_api=True,
        extra_compile_args=["-O3", "-fno-math-errno", "-fno-trapping-math", "-fopenmp-simd"],
    )


setup(
    ext_modules=[compiled(source) for source in SOURCES],
    options={"bdist_wheel": {"py_limited_api": "cp311"}, "build_ext": {"parallel": os.cpu_count() or 1}},
)
