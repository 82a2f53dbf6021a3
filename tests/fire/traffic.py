"""Requests of ordinary use: scans of all kinds, in several sizes and formats, prepared once."""

import gzip
from collections.abc import Callable
from functools import cache

import numpy as np

from primfit.benchmark.service import as_json, csv, npy, scan
from primfit.synthetic.recipes import KINDS
from tests.fire.load import request
from tests.paths import EXAMPLES

SEED = 18
NPY, CSV, JSON = "application/x-npy", "text/csv", "application/json"


@cache
def points(kind: str, n_points: int) -> np.ndarray:
    return scan(SEED, kind, n_points).points


def fits(
    n_points: int, write: Callable[[np.ndarray], bytes] = npy, media_type: str = NPY, **headers: str
) -> list[bytes]:
    """`POST /fit` of a scan of each kind."""
    return [request("/fit", write(points(kind, n_points)), media_type, **headers) for kind in KINDS]


def upload(file: bytes, options: bytes = b"{}") -> tuple[bytes, str]:
    """A multipart body of a file with its options, and its media type."""
    parts = [
        b'--xyz\r\nContent-Disposition: form-data; name="options"\r\n\r\n' + options,
        b'\r\n--xyz\r\nContent-Disposition: form-data; name="file"; filename="scan.npy"\r\n\r\n' + file,
        b"\r\n--xyz--\r\n",
    ]
    return b"".join(parts), "multipart/form-data; boundary=xyz"


def mixed() -> list[bytes]:
    """What a service is asked in a day, in about these shares, small and large, each once."""
    plane, cylinder = points("plane", 3000), points("cylinder", 3000)
    packed = gzip.compress(csv(cylinder))
    segments = (EXAMPLES / "segments.csv").read_bytes()
    small = [*fits(300, csv, CSV), *fits(300, as_json, JSON), *fits(3000)]
    others = [
        request("/fit", packed, CSV, Content_Encoding="gzip"),
        request("/fit?criterion=least_squares&kinds=plane", npy(plane), NPY),
        request("/fit", *upload(npy(cylinder), b'{"tolerance": 0.01}')),
        request("/fit/export?artifacts=glb,csv,report", npy(cylinder), NPY),
        request("/fit/batch?labels=label", segments, CSV),
        request("/fit", npy(points("cylinder", 30_000)), NPY),  # 720 kB: kept in a file meanwhile
        request("/fit", b"1,2,3\n4,5,6\n", CSV),
        *(request(path, method="GET") for path in ("/capabilities", "/metrics", "/readyz", "/docs")),
    ]
    return small * 2 + others
