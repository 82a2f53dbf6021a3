"""Bytes of a file that are spoilt at random: bits, numbers, pieces, lines, ends."""

import random
import re
import struct

LARGEST = 2**20
"""Bytes: what would become larger ends there."""
NUMBERS = (
    b"0", b"-1", b"1", b"2", b"3", b"255", b"65535", b"65536", b"2147483647", b"4294967295", b"4294967296",
    b"18446744073709551615", b"99999999999999999999", b"1e9", b"1e-320", b"1e308", b"1e309", b"-1e999",
    b"nan", b"-inf", b"0x10", b"1_000", b"1.5.5", b"1d5", b"", b"9" * 5000, b"0." + b"0" * 5000 + b"1",
)  # fmt: skip
WORDS = (
    b"\0", b"\n", b"\r\n", b"\r", b",", b";", b"\t", b" ", b'"', b"'", b"{", b"[", b"}", b"]", b"--xyz",
    b"\xff\xfe", b"\xef\xbb\xbf", b"\xf0\x9f\x92\xa9", b"#", b"//", b"\x1a", b"nan", b"null",
    b"list uchar int vertex_indices", b"property double x", b"element vertex 4000000", b"comment ",
    b"DATA binary", b"PK\x03\x04", b"\x1f\x8b\x08\0",
)  # fmt: skip


def mutated(rng: random.Random, data: bytes, most: int = 6) -> bytes:
    """The file after one to `most` mutations; early bytes, where headers stand, are hit more often."""
    for _ in range(rng.randint(1, most)):
        data = rng.choice(_MUTATIONS)(rng, data)[:LARGEST]
    return data


def _place(rng: random.Random, data: bytes) -> int:
    """Log-uniform in half of the cases, else uniform."""
    if rng.random() < 0.5:
        return min(len(data), int((len(data) + 1) ** rng.random()) - 1)
    return rng.randint(0, len(data))


def _put(data: bytes, place: int, new: bytes) -> bytes:
    return data[:place] + new + data[place + len(new) :]


def _flip(rng: random.Random, data: bytes) -> bytes:
    for _ in range(rng.choice((1, 1, 2, 8, 64))):
        if data:
            place = min(_place(rng, data), len(data) - 1)
            data = _put(data, place, bytes([data[place] ^ 1 << rng.randrange(8)]))
    return data


def _write_number(rng: random.Random, data: bytes) -> bytes:
    """A number in binary that counts, places or coordinates should not be."""
    if rng.random() < 0.3:
        value = rng.choice((float("nan"), float("inf"), 1e308, -1e308, 5e-324, 0.0))
        packed = struct.pack(rng.choice("<>") + "d", value)
    else:
        size = rng.choice((1, 2, 4, 8))
        value = rng.choice(
            (0, 1, -1, 2 ** (8 * size - 1) - 1, 2 ** (8 * size - 1), rng.getrandbits(8 * size))
        )
        packed = (value % 2 ** (8 * size)).to_bytes(size, rng.choice(("little", "big")))
    return _put(data, _place(rng, data), packed)


def _another_number(rng: random.Random, data: bytes) -> bytes:
    """Another number in place of one of a text."""
    found = list(re.finditer(rb"-?\d+(\.\d+)?", data[: 64 * 1024]))
    if not found:
        return data
    match = found[min(_place(rng, bytes(len(found))), len(found) - 1)]
    return data[: match.start()] + rng.choice(NUMBERS) + data[match.end() :]


def _insert(rng: random.Random, data: bytes) -> bytes:
    place = _place(rng, data)
    new = rng.choice(
        (rng.choice(WORDS), rng.choice(NUMBERS), rng.randbytes(rng.randint(1, 64)), bytes(10**5))
    )
    return data[:place] + new + data[place:]


def _repeat(rng: random.Random, data: bytes) -> bytes:
    """A piece, or a line, many times."""
    start = _place(rng, data)
    stop = data.find(b"\n", start) + 1 if rng.random() < 0.5 else start + rng.choice((1, 4, 100))
    piece = data[start : max(stop, start + 1)]
    times = min(rng.choice((2, 10, 1000, 50_000)), LARGEST // max(1, len(piece)))
    return data[:start] + piece * times + data[start:]


def _drop(rng: random.Random, data: bytes) -> bytes:
    start = _place(rng, data)
    return data[:start] + data[start + rng.choice((1, 2, 8, 100, 1000)) :]


def _cut(rng: random.Random, data: bytes) -> bytes:
    return data[: _place(rng, data)]


def _join(rng: random.Random, data: bytes) -> bytes:
    """Its beginning and its end, with a piece left out or twice."""
    return data[: _place(rng, data)] + data[_place(rng, data) :]


_MUTATIONS = (
    _flip, _flip, _write_number, _write_number, _another_number, _another_number, _insert, _repeat, _drop,
    _cut, _join,
)  # fmt: skip
