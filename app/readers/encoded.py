"""Arrays in JSON as base64: {"dtype": "float64", "shape": [N, 3], "base64": "..."}, little-endian."""

import math
from binascii import Error, a2b_base64
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from .errors import InvalidPointsError, describe
from .limits import Limits

DtypeName = Literal[
    "float32", "float64", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64"
]
DTYPES = get_args(DtypeName)
INTEGERS = DTYPES[2:-1]  # those that int64 holds
_KEYS = ("dtype", "shape", "base64")


def decode(
    value: dict[str, Any],
    field: str,
    limits: Limits,
    width: int | None = None,
    dtypes: tuple[str, ...] = DTYPES,
) -> NDArray[Any]:
    """The array (N,), or (N, `width`); its length is held against that of the text before it is decoded.

    Raises `InvalidPointsError` naming the part that is wrong, `TooLargeError` over `limits.points`.
    """
    for name in (*_KEYS, *value):
        if name not in value or name not in _KEYS:
            found = "unknown" if name in value else "missing"
            raise InvalidPointsError(f"{field}.{name}"[:60], f"an array has {', '.join(_KEYS)}", found)
    dtype, shape, text = (value[name] for name in _KEYS)
    if dtype not in dtypes:
        raise InvalidPointsError(
            f"{field}.dtype", f"dtype must be one of {', '.join(dtypes)}", describe(dtype)
        )
    if not _has_shape(shape, width):
        expected = "[N]" if width is None else f"[N, {width}]"
        raise InvalidPointsError(f"{field}.shape", f"shape must be {expected}", describe(shape))
    limits.check_points(shape[0], field)
    n_bytes = math.prod(shape) * np.dtype(dtype).itemsize
    decoded = _bytes(text, n_bytes, f"{field}.base64")
    return np.frombuffer(decoded, np.dtype(dtype).newbyteorder("<")).reshape(shape)


def _has_shape(shape: object, width: int | None) -> bool:
    """Whether it is [N], or [N, width]."""
    if not isinstance(shape, list) or not all(type(side) is int and side >= 0 for side in shape):
        return False
    return (len(shape), *shape[1:]) == ((1,) if width is None else (2, width))


def _bytes(text: object, n_bytes: int, field: str) -> bytes:
    """So many bytes from their text."""
    n_letters = 4 * -(-n_bytes // 3)
    if not isinstance(text, str) or len(text) != n_letters:
        message = f"{n_bytes} bytes are {n_letters} characters of base64"
        raise InvalidPointsError(field, message, describe(text))
    try:
        decoded = a2b_base64(text, strict_mode=True)
    except (Error, ValueError):
        decoded = b""
    if len(decoded) != n_bytes:
        raise InvalidPointsError(field, "not base64 (RFC 4648, section 4), or wrongly padded")
    return decoded
