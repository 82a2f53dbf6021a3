"""gzip and zstd data, unpacked within a limit.

It is unpacked twice, first to count: a bomb then costs the time to reach the limit and no memory, and what is
within the limit is allocated once, at its size. `backports.zstd` is the module `compression.zstd` of Python
3.14; unlike other bindings it bounds every step, whatever a frame declares, and tells where a frame ends.
"""

import sys
import zlib
from collections.abc import Generator, Iterator
from typing import Any

from .errors import TooLargeError, UnreadableFileError
from .limits import Limits

CODINGS = ("gzip", "zstd")
_MAGIC = {"gzip": (b"\x1f\x8b",), "zstd": (b"\x28\xb5\x2f\xfd",)}
# zstd also has frames that hold no data, in sixteen kinds.
_SKIPPED = tuple(bytes([kind]) + b"\x2a\x4d\x18" for kind in range(0x50, 0x60))
_PIECE = 64 * 1024
_WINDOW_LOG = 23
_MOST_FRAMES = 10_000


def coding_of(data: memoryview) -> str | None:
    """`gzip` or `zstd` where the bytes start like such data."""
    start = bytes(data[:4])
    return next((coding for coding in CODINGS if start.startswith(_MAGIC[coding])), None)


def unpack(data: memoryview, coding: str, limits: Limits, field: str = "file") -> memoryview:
    """What `data` holds, all of its members or frames one after the other.

    Raises `TooLargeError` over `limits.unpacked_bytes`, `UnreadableFileError` naming `field` where the data
    is broken, ends early, is followed by something else, or is packed in a window of more than 8 MiB.
    """
    n_bytes = 0
    for piece in _pieces(data, coding, field):
        n_bytes += len(piece)
        limits.check_unpacked(n_bytes, len(data), field)
    unpacked = memoryview(bytearray(n_bytes))
    start = 0
    for piece in _pieces(data, coding, field):
        unpacked[start : start + len(piece)] = piece
        start += len(piece)
    return unpacked.toreadonly()


def _pieces(data: memoryview, coding: str, field: str) -> Iterator[bytes]:
    """The unpacked data in pieces of at most 64 KiB, whatever it is unpacked from."""
    start = 0
    for _ in range(_MOST_FRAMES):
        start = yield from _frame(data, start, coding, field)
        if start == len(data):
            return
        following = bytes(data[start : start + 4])
        if not following.startswith(_MAGIC[coding] + (_SKIPPED if coding == "zstd" else ())):
            raise UnreadableFileError(field, f"the {coding} data is followed by something else")
    raise TooLargeError(field, f"the {coding} data has more than {_MOST_FRAMES} members, the limit")


def _frame(data: memoryview, start: int, coding: str, field: str) -> Generator[bytes, None, int]:
    """The pieces of one member or frame; returns where the next one starts."""
    decoder, failures = _decoder(coding)
    try:
        while not decoder.eof:
            packed = data[start : start + _PIECE]
            if not packed:
                raise UnreadableFileError(field, f"the {coding} data ends early")
            start += len(packed)
            piece = decoder.decompress(packed, _PIECE)
            while piece:
                yield piece
                rest = getattr(decoder, "unconsumed_tail", b"")  # zstd keeps it to itself
                piece = b"" if decoder.eof else decoder.decompress(rest, _PIECE)
    except failures as error:
        window = ", or packed in a window of more than 8 MiB" if coding == "zstd" else ""
        raise UnreadableFileError(field, f"the {coding} data is broken{window}") from error
    return start - len(decoder.unused_data)


def _decoder(coding: str) -> tuple[Any, type[Exception]]:
    """A decoder of one member or frame, and what it raises."""
    if coding == "gzip":
        return zlib.decompressobj(zlib.MAX_WBITS | 16), zlib.error
    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd
    return zstd.ZstdDecompressor(
        options={zstd.DecompressionParameter.window_log_max: _WINDOW_LOG}
    ), zstd.ZstdError
