"""Hostile requests without end, each from its own number: files, packings, uploads, JSON, options and heads.

`python -m tests.fire.fuzz NUMBER > request.bin` writes one of them again.
"""

import gzip
import json
import random
import sys
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple
from urllib.parse import quote, urlencode

import trimesh
import zstandard

from primfit.app.exports import FORMATS as ARTIFACTS
from primfit.app.service.media_types import MEDIA_TYPES
from primfit.app.wire.options import ALLOWED
from primfit.fitting.names import ANSWER_PARTS, CRITERIA, KINDS
from tests.app.readers.written import POINTS, e57, las, laz, npy, npz, pcd, ply, records
from tests.fire.load import request
from tests.fire.mutations import mutated
from tests.fire.traffic import upload
from tests.paths import EXAMPLES

SEED = 18


class Hostile(NamedTuple):
    """A request as it travels, and the statuses `expected`, where it is known which.

    One whose `head` was spoilt may be left without an answer.
    """

    name: str
    content: bytes
    head: bool = False
    expected: frozenset[int] | None = None


def hostile(number: int) -> Hostile:
    """The request of this number, always the same."""
    rng = random.Random(f"{SEED}:{number}")
    ways: list[Callable[[random.Random], Hostile]] = [_file, _packed, _upload, _json, _options, _batch, _head]
    make = rng.choices(ways, weights=(40, 8, 10, 14, 12, 6, 10))[0]
    return make(rng)._replace(name=f"{number} {make.__name__[1:]}")


# Files ------------------------------------------------------------------------------------------------------


@cache
def seeds() -> tuple[tuple[str, bytes], ...]:
    """A small file of every format and dialect, with its media type."""
    mesh = trimesh.creation.cylinder(1.0, 3.0, sections=12)
    vertices = (records(POINTS), "vertex")
    rows = b"".join(b"%r %r %r\n" % tuple(row) for row in POINTS.tolist())
    pose = b"0 0 0\n" * 4 + b"1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    made = {
        "application/x-npy": [npy(POINTS), npy(POINTS.astype("f4"))],
        "application/octet-stream": [
            npz(points=POINTS),
            npz(compressed=False, points=POINTS),
            e57(POINTS),
            b"60\n" + rows.replace(b"\n", b" 7\n"),
            b"6\n10\n" + pose + rows.replace(b"\n", b" 0.5\n"),
            *(_exported(mesh, kind) for kind in ("glb", "stl", "stl_ascii", "obj")),
        ],
        "model/ply": [ply(vertices), ply(vertices, text=True), ply(vertices, order=">")],
        "text/csv": [
            b"x,y,z\n" + rows.replace(b" ", b","),
            rows,
            b"sep=;\nx;y;z\n" + rows.replace(b" ", b";"),
        ],
    }
    made["application/octet-stream"] += [
        pcd(POINTS, kind) for kind in ("ascii", "binary", "binary_compressed")
    ]
    made["application/octet-stream"] += [las(), laz(), las(version="1.2", format=1)]
    return tuple((media_type, file) for media_type, files in made.items() for file in files)


def _exported(mesh: trimesh.Trimesh, kind: str) -> bytes:
    written = mesh.export(file_type=kind)
    return written.encode() if isinstance(written, str) else written


def _file(rng: random.Random) -> Hostile:
    media_type, file = rng.choice(seeds())
    if rng.random() < 0.2:
        media_type = rng.choice(MEDIA_TYPES)
    if rng.random() < 0.1:  # the beginning of one and the end of another
        other = rng.choice(seeds())[1]
        file = file[: rng.randrange(len(file))] + other[rng.randrange(len(other)) :]
    return Hostile("", request(_path(rng), mutated(rng, file), media_type))


def _packed(rng: random.Random) -> Hostile:
    """Spoilt before it is packed, after, or both; packed up to three times."""
    _, file = rng.choice(seeds())
    spoil = rng.choice(("before", "after", "both"))
    file = file if spoil == "after" else mutated(rng, file)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        file = gzip.compress(file, mtime=0) if rng.random() < 0.5 else zstandard.compress(file)
    file = file if spoil == "before" else mutated(rng, file)
    coding = {"Content_Encoding": rng.choice(("gzip", "zstd", "x-gzip"))} if rng.random() < 0.5 else {}
    return Hostile("", request(_path(rng), file, "application/octet-stream", **coding))


_BOUNDARIES = (
    "multipart/form-data",
    "multipart/form-data; boundary=",
    'multipart/form-data; boundary="x\\"',
    "multipart/mixed; boundary=xyz",
)


def _upload(rng: random.Random) -> Hostile:
    _, file = rng.choice(seeds())
    body, media_type = upload(mutated(rng, file) if rng.random() < 0.5 else file, _options_text(rng))
    if rng.random() < 0.7:  # what stands between the parts
        frame = body.replace(file, b"@FILE@")
        body = mutated(rng, frame, most=3).replace(b"@FILE@", file)
    if rng.random() < 0.2:
        media_type = rng.choice((*_BOUNDARIES, media_type + "z" * 80))
    return Hostile("", request(_path(rng), body, media_type))


_FILE_NAMES = (b"a.csv", b"../../a.csv", b"", b"a\0.ply", b"\xff.npy", b"a" * 5000)


def _batch(rng: random.Random) -> Hostile:
    """A file with labels, or an upload of several files, to the route that answers line by line."""
    if rng.random() < 0.5:
        file = (EXAMPLES / "segments.csv").read_bytes()
        query = urlencode({"labels": rng.choice(("label", "x", "4", "nothing", "", "é"))})
        return Hostile("", request(f"/fit/batch?{query}", mutated(rng, file), "text/csv"))
    parts = []
    for i in range(rng.randrange(1, 12)):
        named = b'name="file"; filename="%s"' % rng.choice(
            (b"a.csv", b"../../a.csv", b"", b"a\0.ply", b"%d.npy" % i)
        )
        _, file = rng.choice(seeds())
        content = file if rng.random() < 0.3 else mutated(rng, file)
        parts.append(b"--xyz\r\nContent-Disposition: form-data; %s\r\n\r\n%s\r\n" % (named, content))
    return Hostile(
        "", request("/fit/batch", b"".join(parts) + b"--xyz--\r\n", "multipart/form-data; boundary=xyz")
    )


def _path(rng: random.Random) -> str:
    export = f"/fit/export?artifacts={rng.choice(tuple(ARTIFACTS))}"
    return rng.choices(("/fit", export, "/fit/batch"), weights=(80, 10, 10))[0]


# JSON and options -------------------------------------------------------------------------------------------

_VALUES: tuple[Any, ...] = (
    None, True, False, 0, 1, -1, 2**31, 2**63, 2**64, 10**30, 0.5, 1e-300, 1e308, -0.0, "", "a", "é",
    "\ud800", "\0", "nan", "Infinity", "x" * 3000, [], [[]], {}, {"kind": "cone"}, {"": {}}, [1, 2, 3],
    [0, 0, 0], [1e308] * 3, [[1, 2, 3]] * 4, {"value": 1, "tolerance": [0, 0]}, {"min": 2, "max": 1},
    {"value": [0, 0, 1], "max_angle": 0}, *KINDS, *CRITERIA, *ANSWER_PARTS, "knn", "none", "network",
    "error", "drop", "mm", list(KINDS), ["cone", "cone"],
)  # fmt: skip
_NAMES = (
    *ALLOWED, "points", "normals", "weights", "labels", "standard_deviations", "kind", "axis", "apex",
    "center", "radius", "major_radius", "minor_radius", "half_angle", "normal", "point", "value",
    "tolerance", "min", "max", "max_angle", "dtype", "shape", "base64", "options", "", "__proto__",
    "x" * 300,
)  # fmt: skip


def _value(rng: random.Random, depth: int = 3) -> Any:
    draw = rng.random()
    if depth and draw < 0.15:
        return {rng.choice(_NAMES): _value(rng, depth - 1) for _ in range(rng.randint(0, 4))}
    if depth and draw < 0.25:
        return [_value(rng, depth - 1) for _ in range(rng.randint(0, 5))]
    if draw < 0.35:
        return rng.uniform(-2, 2) * 10 ** rng.randint(-12, 12)
    return rng.choice(_VALUES)


def _some_options(rng: random.Random) -> dict[str, Any]:
    """Options that exist, most with values that they do not take."""
    chosen = {rng.choice(ALLOWED): _value(rng) for _ in range(rng.randint(1, 4))}
    if rng.random() < 0.3:
        chosen["criterion"], chosen["kinds"] = rng.choice(CRITERIA), [rng.choice(KINDS)]
    if rng.random() < 0.1:
        chosen[rng.choice(_NAMES)] = _value(rng)
    return chosen


def _options_text(rng: random.Random) -> bytes:
    text = json.dumps(_some_options(rng)).encode()
    return mutated(rng, text, most=2) if rng.random() < 0.3 else text


def _json(rng: random.Random) -> Hostile:
    """A body in JSON that is well-formed and wrong, or that is not well-formed."""
    rows = POINTS.tolist()[: rng.choice((0, 1, 3, 10, 60))]
    body: dict[str, Any] = {"points": rows, "options": _some_options(rng)}
    for _ in range(rng.randint(0, 3)):
        body[rng.choice(_NAMES)] = _value(rng)
    if rows and rng.random() < 0.4:
        rows[rng.randrange(len(rows))] = _value(rng)
    text = json.dumps(body).encode()
    text = mutated(rng, text, most=3) if rng.random() < 0.4 else text
    return Hostile("", request("/fit", text, "application/json"))


def _options(rng: random.Random) -> Hostile:
    """Odd queries beside a good cloud."""
    pairs = []
    for name, value in _some_options(rng).items():
        for one in value if isinstance(value, list) and rng.random() < 0.7 else [value]:
            pairs.append((name, one if isinstance(one, str) else json.dumps(one)))
    query = urlencode([(name, value.encode("utf-8", "replace")) for name, value in pairs])
    if rng.random() < 0.3:
        query = quote(mutated(rng, query.encode(), most=2)[:4000], safe="&=%+,;[]")
    path = "/fit/export?artifacts=csv&" if rng.random() < 0.2 else "/fit?"
    return Hostile("", request(path + query, rng.choice(seeds())[1]))


# Heads ------------------------------------------------------------------------------------------------------

_LINES = (
    b"Content-Length: 5", b"Content-Length: -1", b"Content-Length: 99999999999999999999",
    b"Content-Length: 1e3", b"Content-Length : 5", b"Content-Length: 5, 5", b"Transfer-Encoding: chunked",
    b"Transfer-Encoding: identity", b"Transfer-Encoding: gzip, chunked",
    b"Transfer-Encoding: chunked, chunked", b"Transfer-Encoding:\x0bchunked", b"Expect: 100-continue",
    b"Expect: nothing", b"Connection: close", b"Connection: upgrade\r\nUpgrade: websocket",
    b"Upgrade: h2c\r\nHTTP2-Settings: AAAA\r\nConnection: upgrade", b"Host: evil.example", b"Host:",
    b"Host: a\r\nHost: b", b"Origin: https://evil.example", b"Content-Type: text/csv; charset=\xff",
    b"Content-Type:", b"Content-Encoding: gzip, gzip, gzip", b"Content-Encoding: br", b"If-None-Match: *",
    b"If-None-Match: " + b'"a",' * 2000, b"Prefer: wait=-1", b"Prefer: wait=1e400",
    b"Prefer: respond-async, wait=0", b"X-Request-Id: \x00\x01", b"X-Request-Id: " + b"a" * 9000,
    b"X-Forwarded-For: " + b"1.1.1.1, " * 500, b"traceparent: 00-zz-zz-zz",
    b"Authorization: Bearer " + b"\xff" * 50, b"Range: bytes=0-0", b" folded: line", b"no colon",
    b": no name", b"Name with blanks: 1", b"A: " + b"a" * 70_000,
    b"\r\n".join(b"A%d: 1" % i for i in range(150)), b"Accept: " + b"*/*;q=0.1," * 800,
    b"Idempotency-Key: " + b"\"" * 99,
)  # fmt: skip
_TARGETS = (
    b"/fit", b"/", b"//", b"*", b"/fit/../fit", b"/%2e%2e/%2e%2e/etc/passwd", b"/fit%00", b"/%ff%fe",
    b"http://x/fit", b"/fit?" + b"a" * 20_000, b"/fit?%", b"/fit?a=%ff", b"/fit\x00", b"/f\xc3\xa9",
    b"/fit#fragment", b"/jobs", b"/jobs/../fit", b"/openapi.json", b"/docs", b"/metrics", b"/livez",
    b"/capabilities", b"\x80",
)  # fmt: skip
_METHODS = (
    b"GET", b"HEAD", b"OPTIONS", b"PUT", b"PATCH", b"DELETE", b"TRACE", b"CONNECT", b"PRI", b"post",
    b"POST" * 30, b"",
)  # fmt: skip


def _head(rng: random.Random) -> Hostile:
    """A request whose head was spoilt: lines added, repeated, cut, another method or target, any bytes."""
    head, _, body = request("/fit", b"1,2,3\n4,5,6\n7,8,10\n", "text/csv").partition(b"\r\n\r\n")
    lines = head.split(b"\r\n")
    if rng.random() < 0.4:
        method = rng.choice(_METHODS) if rng.random() < 0.5 else b"POST"
        version = rng.choice((b"HTTP/1.1", b"HTTP/1.1", b"HTTP/1.0", b"HTTP/9.9", b"http/1.1", b""))
        lines[0] = b" ".join((method, rng.choice(_TARGETS), version))
    for _ in range(rng.randint(0, 3)):
        lines.insert(rng.randint(1, len(lines)), rng.choice(_LINES))
    content = rng.choice((b"\r\n", b"\r\n", b"\r\n", b"\n", b"\r")).join(lines) + b"\r\n\r\n" + body
    if rng.random() < 0.4:
        content = mutated(rng, content, most=3)
    return Hostile("", content, head=True)


if __name__ == "__main__":
    sys.stdout.buffer.write(hostile(int(sys.argv[1])).content)
