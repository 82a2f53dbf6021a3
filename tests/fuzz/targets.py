"""What is fuzzed: each target takes bytes, and returns a cloud or nothing, or raises what is wrong."""

from collections.abc import Callable
from urllib.parse import parse_qsl
from zlib import crc32

from primfit.app.readers import Cloud, Pick, coding_of, read, read_json, unpack
from primfit.app.readers.columns import AUTO_LABELS
from primfit.app.readers.e57 import read_e57
from primfit.app.readers.glb import read_glb
from primfit.app.readers.las import read_las
from primfit.app.readers.npy import read_npy
from primfit.app.readers.npz import read_npz
from primfit.app.readers.obj import read_obj
from primfit.app.readers.pcd import read_pcd
from primfit.app.readers.ply import read_ply
from primfit.app.readers.ptx import read_ptx
from primfit.app.readers.stl import read_stl
from primfit.app.readers.text import read_text
from primfit.app.service.settings import Settings
from primfit.app.wire.multipart import find_parts
from primfit.app.wire.options import check_options, parse_options

LIMITS = Settings().limits
_PICKS = (Pick(), Pick(labels=AUTO_LABELS), Pick(columns=(2, 3, 1)))


def _table(read: Callable[..., Cloud]) -> Callable[[bytes], Cloud]:
    """A reader that is asked for other columns of other inputs, and of the same one always for the same."""
    return lambda data: read(memoryview(data), LIMITS, _PICKS[crc32(data) % len(_PICKS)])


def _reader(read: Callable[..., Cloud]) -> Callable[[bytes], Cloud]:
    return lambda data: read(memoryview(data), LIMITS)


def _json(data: bytes) -> Cloud:
    cloud = read_json(memoryview(data), LIMITS)
    check_options([], {}, cloud.options)
    return cloud


def _packed(data: bytes) -> None:
    view = memoryview(data)
    unpack(view, coding_of(view) or "gzip", LIMITS)


def _multipart(data: bytes) -> None:
    """The first line is the content type of the others."""
    content_type, _, body = data.partition(b"\n")
    for part in find_parts(body, content_type.decode("latin-1"), most_files=3):
        assert 0 <= part.start <= part.stop <= len(body)


def _options(data: bytes) -> None:
    """The first line is a query, the others are JSON."""
    query, _, text = data.partition(b"\n")
    pairs = parse_qsl(query.decode("latin-1"), keep_blank_values=True)
    check_options(pairs, parse_options(text) if text else {})


TARGETS: dict[str, Callable[[bytes], Cloud | None]] = {
    "text": _table(read_text),
    "ply": _table(read_ply),
    "pcd": _table(read_pcd),
    "las": _table(read_las),
    "e57": _reader(read_e57),
    "npy": _table(read_npy),
    "npz": _table(read_npz),
    "glb": _reader(read_glb),
    "obj": _reader(read_obj),
    "stl": _reader(read_stl),
    "ptx": _reader(read_ptx),
    "json": _json,
    "packed": _packed,
    "multipart": _multipart,
    "options": _options,
    "any": _table(read),
}
"""By the name of what they read; `any` finds the format out, as the service does."""
