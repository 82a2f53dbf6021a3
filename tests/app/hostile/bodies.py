"""Hostile bodies, texts, packed files, meshes and uploads, each with the field that its refusal names."""

import base64
import gzip
import io
import json
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import zstandard

from tests.paths import EXAMPLES

REQUEST = (EXAMPLES / "request.json").read_bytes()
CSV = (EXAMPLES / "cylinder.csv").read_bytes()
MIB = 2**20
Make = Callable[[], bytes]


# Bodies that hold a cloud in any format.


def _npy(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def _array(values: Any, kind: str = "<f8", **changes: object) -> dict[str, Any]:
    """A base64 array, with some of its fields changed or, with None, left out."""
    array = np.asarray(values, kind)
    encoded = {
        "dtype": array.dtype.name,
        "shape": list(array.shape),
        "base64": base64.b64encode(array.tobytes()).decode(),
    }
    return {name: value for name, value in {**encoded, **changes}.items() if value is not None}


GRID = np.random.default_rng(4).normal(size=(50, 3))
BASE64 = _array(GRID)["base64"]


def _json(points: object = GRID.tolist(), **beside: object) -> bytes:
    return json.dumps({"points": points, **beside}).encode()


def _with_nan(width: int | None = 3) -> dict[str, Any]:
    values = GRID.copy() if width else GRID[:, 0].copy()
    values[7] = np.nan
    return _array(values)


PTX_POSE = b"0 0 0\n" * 4 + b"1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
NOT_FINITE: dict[str, tuple[Make, str]] = {
    "NaN in points": (lambda: b'{"points": [[1, 2, NaN]]}', "points[0][2]"),
    "Infinity in points": (lambda: b'{"points": [[1, 2, 3], [-Infinity, 2, 3]]}', "points[1][0]"),
    "1e999 in points": (lambda: b'{"points": [[1, 1e999, 3]]}', "points[0][1]"),
    "an integer of 5,000 digits": (lambda: b'{"points": [[1, %s, 3]]}' % (b"7" * 5000), "points[0][1]"),
    "NaN in weights": (lambda: b'{"points": [[1, 2, 3]], "weights": [NaN]}', "weights[0]"),
    "NaN in deviations": (lambda: b'{"points": [[1, 2, 3]], "standard_deviations": [NaN]}',
                          "standard_deviations[0]"),
    "1e999 in normals": (lambda: b'{"points": [[1, 2, 3]], "normals": [[0, 1e999, 1]]}', "normals[0][1]"),
    "NaN in labels": (lambda: b'{"points": [[1, 2, 3]], "labels": [NaN]}', "labels[0]"),
    "NaN in max_error": (lambda: b'{"points": [], "options": {"max_error": NaN}}', "options.max_error"),
    "NaN in base64": (lambda: _json(_with_nan()), "points[7][0]"),
    "infinity in base64 of float32": (lambda: _json(_array([[1, 2, np.inf]], "<f4")), "points[0][2]"),
    "NaN in base64 normals": (lambda: _json(normals=_with_nan()), "normals[7]"),
    "a normal of zeros": (lambda: _json(normals=[[0, 0, 0]] * 50), "normals[0]"),
    "nan in csv": (lambda: b"1,2,3\n4,nan,6\n", "points[1][1]"),
    "inf in csv": (lambda: b"1,2,3\n4,5,-inf\n", "points[1][2]"),
    "1e999 in csv": (lambda: b"1,2,3\n1e999,5,6\n", "points[1][0]"),
    "nan in all of a big array": (lambda: _npy(np.full((600_000, 3), np.nan)), "points[0][0]"),
    "nan in obj": (lambda: b"v 1 2 3\nv 1 nan 3\n", "points[1][1]"),
    "nan in ascii stl": (lambda: STL_ASCII.replace(b"1.5", b"nan"), "points[0][0]"),
    "infinity in binary stl": (lambda: _stl([[[np.inf, 2, 3], [4, 5, 6], [7, 8, 9]]]), "points[0][0]"),
    "infinity in glb": (lambda: glb(np.array([[1, 2, np.inf]])), "points[0][2]"),
    "glb that a node blows up": (
        lambda: glb(np.full((4, 3), 1e9), nodes=[{"mesh": 0, "scale": [1e308] * 3}]), "points[0][0]"),
}  # fmt: skip
JSON: dict[str, tuple[Make, str]] = {
    "depth of 10^6": (lambda: b'{"points": ' + b"[" * 10**6 + b"]" * 10**6 + b"}", "points"),
    "depth of 10^5": (lambda: b'{"points": ' + b"[" * 10**5 + b"]" * 10**5 + b"}", "body"),
    "objects 10^5 deep": (lambda: b'{"points": ' * 10**5, "body"),
    "100,000 bad rows": (lambda: _json([["s3cret", 1]] * 100_000), "points[0]"),
    "5 million values": (lambda: b'{"points": [' + b"0," * 5_000_000 + b"0]}", "points"),
    "a million strings": (lambda: b'{"labels": [' + b'"a",' * 10**6 + b'"a"]}', "points"),
    "a string of 10 MB": (lambda: _json("s3cret" * 1_600_000), "points"),
    "labels of two types": (lambda: _json(labels=[1, "a"] * 25), "labels"),
    "labels with fractions": (lambda: _json(labels=[0.5] * 50), "labels"),
    "labels beyond 64 bits": (lambda: _json(labels=[2**64 - 1] * 50), "labels"),
    "a label of 10,000 letters": (lambda: _json(labels=["a" * 10_000] * 50), "labels"),
    "too few labels": (lambda: _json(labels=[1] * 49), "labels"),
    "too many normals": (lambda: _json(normals=[[0, 0, 1]] * 51), "normals"),
    "base64 one letter short": (lambda: _json(_array(GRID, base64=BASE64[:-1])), "points.base64"),
    "base64 four letters long": (lambda: _json(_array(GRID, base64=BASE64 + "AAAA")), "points.base64"),
    "base64 without padding": (lambda: _json(weights=_array(GRID[:, 0], base64="A" * 534)), "weights.base64"),
    "base64 padded in the middle": (lambda: _json(_array(GRID, base64="AA==" + BASE64[4:])), "points.base64"),
    "base64 of the url alphabet": (lambda: _json(_array(GRID, base64="-_" + BASE64[2:])), "points.base64"),
    "base64 with a line break": (lambda: _json(_array(GRID, base64=BASE64[:-1] + "\n")), "points.base64"),
    "base64 that is not ascii": (lambda: _json(_array(GRID, base64="é" + BASE64[1:])), "points.base64"),
    "base64 as array": (lambda: _json(_array(GRID, base64=[1])), "points.base64"),
    "base64 of objects": (lambda: _json(_array(GRID, dtype="object")), "points.dtype"),
    "base64 of strings": (lambda: _json(_array(GRID, dtype="U8")), "points.dtype"),
    "base64 in big-endian": (lambda: _json(_array(GRID, dtype=">f8")), "points.dtype"),
    "dtype as array": (lambda: _json(_array(GRID, dtype=["float64"])), "points.dtype"),
    "shape below zero": (lambda: _json(_array(GRID, shape=[-50, 3])), "points.shape"),
    "shape of 10^12": (lambda: _json(_array(GRID, shape=[10**12, 3])), "points"),
    "shape as 1e12": (lambda: _json(_array(GRID, shape=[1e12, 3])), "points.shape"),
    "shape of 10^30": (lambda: _json(_array(GRID, shape=[10**30, 3])), "points.shape"),
    "shape of booleans": (lambda: _json(_array(GRID, shape=[True, 3])), "points.shape"),
    "shape of strings": (lambda: _json(_array(GRID, shape=["50", 3])), "points.shape"),
    "shape of one dimension": (lambda: _json(_array(GRID, shape=[150])), "points.shape"),
    "shape of two columns": (lambda: _json(_array(GRID, shape=[75, 2])), "points.shape"),
    "shape missing": (lambda: _json(_array(GRID, shape=None)), "points.shape"),
    "one field too many": (lambda: _json({**_array(GRID), "order": "F"}), "points.order"),
    "weights of three columns": (lambda: _json(weights=_array(GRID)), "weights.shape"),
    "labels as base64 of uint64": (lambda: _json(labels=_array(range(50), "<u8")), "labels.dtype"),
    "labels as base64 floats": (lambda: _json(labels=_array(GRID[:, 0])), "labels.dtype"),
}
TEXT: dict[str, tuple[Make, str]] = {
    "100,000 bad lines": (lambda: b"1,2,3\n" + b"1,s3cret,3\n" * 100_000, "line 2, column 2"),
    "5 million bad lines": (lambda: b"1,2,3\n" + b"1,x,3\n" * 5_000_000, "line 2, column 2"),
    "faces without vertices": (lambda: b"f 1 2 3\n" * 3_000_000, "line 1, column 1"),
    "a line of 30 MB": (lambda: b"1,2,3\n" * 30 + b"1 " * 15_000_000, "line 31"),
    "a header of 1 MB": (lambda: b"x,y,z" + b",s3cret" * 150_000 + b"\n1,2,3\n", "line 1"),
    "nothing but lines": (lambda: b"\n" * 10_000_000, "file"),
    "nothing but comments": (lambda: b"#\n" * 5_000_000, "file"),
    "bytes without a format": (lambda: bytes(range(256)) * 10_000, "file"),
    "pts of -1 rows": (lambda: b"-1\n1 2 3 4\n1 2 3 4\n", "file"),
    "pts of 1e12 rows": (lambda: b"1e12\n1 2 3 4\n1 2 3 4\n", "file"),
    "ptx of 10^18 points": (lambda: b"999999999\n" * 2 + PTX_POSE + b"1 2 3 4\n", "file"),
    "ptx with a long scan": (lambda: b"1\n1\n" + PTX_POSE + b"1 2 3 4\n" * 10**5, "line 12"),
    "ptx of endless heads": (lambda: (b"0\n0\n" + PTX_POSE) * 10**5, "file"),
    "a number of 60,000 digits": (lambda: (b"1" * 60_000 + b" 2 3.D+\n") * 100, "line 1, column 3"),
    "a short row with a point, beside commas and quotes": (
        lambda: b"sep=;\n" + b"1,5;2,5;3,5\n" * 25 + b'1.5\n"4,0";5,0;6,0\n',
        "line 27",
    ),
    "an OFF header of signs": (lambda: b"OFF " + b"# " * 200 + b"x", "line 1"),
    "20 lines of 32,000 columns": (lambda: (b"1 " * 32_000 + b"\n") * 20, "line 1"),
    "a header of 13,000 eastings": (
        lambda: b"east," * 13_000 + b"\n" + (b"1," * 13_000 + b"\n") * 5,
        "line 1",
    ),
    "ptx of 300,000 scans": (lambda: (b"0\n0\n" + PTX_POSE) * 300_000, "file"),
    "a grid of heights": (lambda: b"ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n", "file"),
}


def _zstd_frame(header: bytes, *blocks: bytes) -> bytes:
    """A frame with this header and raw blocks."""
    raw = b"".join(
        (len(block) << 3 | (i == len(blocks) - 1)).to_bytes(3, "little") + block
        for i, block in enumerate(blocks)
    )
    return b"\x28\xb5\x2f\xfd" + header + raw


def _declaring(n_bytes: int, window: int | None) -> bytes:
    """A frame of `CSV` that declares another size, with a window descriptor or, with None, one segment."""
    flags = bytes([0b11000000]) + bytes([window]) if window is not None else bytes([0b11100000])
    return _zstd_frame(flags + n_bytes.to_bytes(8, "little"), CSV[:1000], CSV[1000:2000])


PACKED: dict[str, tuple[Make, str]] = {
    "gzip bomb": (lambda: gzip.compress(bytes(2**28), 9), "file"),
    "zstd bomb": (lambda: zstandard.compress(bytes(2**28)), "file"),
    "zstd bomb without a size": (
        lambda: zstandard.ZstdCompressor(write_content_size=False).compress(bytes(2**28)), "file"),
    "zstd of 1 TB in a window": (lambda: _declaring(10**12, 0), "file"),
    "zstd of 1 TB in one segment": (lambda: _declaring(10**12, None), "file"),
    "zstd that declares less": (lambda: _declaring(1500, 0), "file"),
    "zstd with a window of 3.75 TB": (lambda: _zstd_frame(b"\0\xff", CSV[:1000]), "file"),
    "zstd with a window of 16 MiB": (lambda: _zstd_frame(b"\0\x70", CSV[:1000]), "file"),
    "zstd with a dictionary": (lambda: _zstd_frame(b"\x01\0\x07", CSV[:1000]), "file"),
    "200,000 zstd frames": (lambda: zstandard.compress(b"") * 200_000, "file"),
    "200,000 gzip members": (lambda: gzip.compress(b"") * 200_000, "file"),
    "gzip of a million rows": (lambda: gzip.compress(b"1 2 3\n" * 10**6), "file"),
    "zstd of a million rows": (lambda: zstandard.compress(b"1 2 3\n" * 10**6), "file"),
    "20 bombs in a row": (lambda: gzip.compress(bytes(2**25)) * 20, "file"),
    "gzip cut in the header": (lambda: gzip.compress(CSV)[:8], "file"),
    "gzip cut in the middle": (lambda: gzip.compress(CSV)[:3000], "file"),
    "gzip cut in the checksum": (lambda: gzip.compress(CSV)[:-5], "file"),
    "gzip with a wrong checksum": (lambda: gzip.compress(CSV)[:-5] + b"\0" * 5, "file"),
    "zstd cut in the header": (lambda: zstandard.compress(CSV)[:5], "file"),
    "zstd cut in the middle": (lambda: zstandard.compress(CSV)[:3000], "file"),
    "zstd cut before the end": (lambda: zstandard.compress(CSV)[:-1], "file"),
    "gzip and garbage": (lambda: gzip.compress(CSV) + b"garbage", "file"),
    "gzip and zeros": (lambda: gzip.compress(CSV) + bytes(512), "file"),
    "zstd and garbage": (lambda: zstandard.compress(CSV) + b"garbage", "file"),
    "gzip in gzip": (lambda: gzip.compress(gzip.compress(CSV)), "file"),
    "zstd in gzip": (lambda: gzip.compress(zstandard.compress(CSV)), "file"),
    "gzip of nothing": (lambda: gzip.compress(b""), "file"),
}  # fmt: skip


def _stl(triangles: Any, announced: int | None = None) -> bytes:
    """A binary STL of these triangles (N, 3, 3)."""
    corners = np.asarray(triangles, "<f4")
    rows = b"".join(bytes(12) + corner.tobytes() + bytes(2) for corner in corners)
    return bytes(80) + struct.pack("<I", len(corners) if announced is None else announced) + rows


TRIANGLES = np.random.default_rng(5).normal(size=(40, 3, 3))
STL_ASCII = (
    b"solid part\nfacet normal 0 0 1\nouter loop\nvertex 1.5 2 3\nvertex 4 5 6\nvertex 7 8 9\nendloop\n"
    b"endfacet\nendsolid part\n"
)


def glb(points: np.ndarray, text: bytes | None = None, **changes: Any) -> bytes:
    """A GLB file of one mesh, with some of the top-level fields of its document, or all of it, replaced."""
    data = np.asarray(points, "<f4").tobytes()
    accessor = {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(points)}
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 0}]}],
        "accessors": [accessor],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(data)}],
        "buffers": [{"byteLength": len(data)}],
    }
    text = json.dumps({**document, **changes}).encode() if text is None else text
    text += b" " * (-len(text) % 4)
    chunks = (
        struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


ACCESSOR = {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 50}


def _accessor(**changes: Any) -> bytes:
    return glb(GRID, accessors=[ACCESSOR | changes])


GLB = glb(GRID)
MESHES: dict[str, tuple[Make, str]] = {
    "stl of 2^32-1 triangles": (lambda: _stl(TRIANGLES, 2**32 - 1), "file"),
    "stl of one triangle more": (lambda: _stl(TRIANGLES, 41), "file"),
    "stl of one triangle less": (lambda: _stl(TRIANGLES, 39), "file"),
    "stl cut in a triangle": (lambda: _stl(TRIANGLES)[:-7], "file"),
    "stl without triangles": (lambda: _stl(np.empty((0, 3, 3))), "file"),
    "ascii stl cut": (lambda: STL_ASCII[:-40], "file"),
    "ascii stl of two corners": (lambda: STL_ASCII.replace(b"vertex 7 8 9\n", b""), "file"),
    "ascii stl of words": (lambda: STL_ASCII.replace(b"5", b"five"), "line 4"),
    "ascii stl of a line of 10 MB": (lambda: STL_ASCII.replace(b"part", b"part" * 2_500_000, 1), "line 1"),
    "ascii stl of 100,000 bad lines": (lambda: STL_ASCII + b"vertex s3cret\n" * 100_000, "line 10"),
    "obj of words": (lambda: b"v 1 2 3\nv 1 two 3\n", "line 2"),
    "obj of two coordinates": (lambda: b"# part\nv 1 2 3\nv 1 2\n", "line 3"),
    "obj of a line of 10 MB": (lambda: b"v 1 2 3\n" + b"f" + b" 1" * 5_000_000, "line 2"),
    "obj of 3 million bad lines": (lambda: b"v 1 2 3\n" + b"v s3cret\n" * 3_000_000, "line 2"),
    "obj of 100,000 bad lines": (lambda: b"v 1 2 3\n" + b"v s3cret\n" * 100_000, "line 2"),
    "glb cut in the header": (lambda: GLB[:11], "file"),
    "glb cut in the json": (lambda: GLB[:100], "header"),
    "glb one byte short": (lambda: GLB[:-1], "header"),
    "glb one byte long": (lambda: GLB + b"\0", "header"),
    "glb of version 1": (lambda: GLB[:4] + b"\1" + GLB[5:], "header"),
    "glb with a chunk of 4 GB": (lambda: GLB[:12] + b"\xff" * 4 + GLB[16:], "file"),
    "glb with json of 2 MB": (lambda: glb(GRID, b"[" + b"{}," * 700_000 + b"{}]"), "file"),
    "glb with json 300,000 deep": (lambda: glb(GRID, b"[" * 300_000 + b"]" * 300_000), "file"),
    "glb with 340,000 objects": (
        lambda: glb(GRID, b'{"scenes":[{"nodes":[-1]}],"nodes":[' + b"{}," * 340_000 + b"{}]}"), "nodes"),
    "glb with 200,000 strings": (
        lambda: glb(GRID, b'{"scenes":[{"nodes":[-1]}],"nodes":[' + b'"ab",' * 200_000 + b'""]}'), "nodes"),
    "glb of broken json": (lambda: glb(GRID, b'{"scene": '), "file"),
    "glb of an array": (lambda: glb(GRID, b"[]"), "file"),
    "glb without a scene": (lambda: glb(GRID, scenes=None), "scene"),
    "glb with scenes as number": (lambda: glb(GRID, scenes=7), "scene"),
    "glb with a node of -1": (lambda: glb(GRID, scenes=[{"nodes": [-1]}]), "nodes"),
    "glb with a node of true": (lambda: glb(GRID, scenes=[{"nodes": [True]}]), "nodes"),
    "glb with a mesh of 1e12": (lambda: glb(GRID, nodes=[{"mesh": 1e12}]), "mesh"),
    "glb with a circle of nodes": (lambda: glb(GRID, nodes=[{"mesh": 0, "children": [0]}]), "nodes[0]"),
    "glb with a matrix of words": (lambda: glb(GRID, nodes=[{"matrix": ["a"] * 16}]), "nodes[0].matrix"),
    "glb with 50,000 nodes": (
        lambda: glb(GRID, scenes=[{"nodes": list(range(50_000))}], nodes=[{}] * 50_000), "nodes[4000]"),
    "glb with 3,900 copies of 500 points": (
        lambda: glb(np.resize(GRID, (500, 3)), scenes=[{"nodes": list(range(3900))}],
                    nodes=[{"mesh": 0}] * 3900), "meshes[0].primitives[0]"),
    "glb with 3,900 views of 500 points": (
        lambda: glb(np.resize(GRID, (500, 3)), accessors=[ACCESSOR | {"count": 500}] * 3900,
                    meshes=[{"primitives": [{"attributes": {"POSITION": i}} for i in range(3900)]}]),
        "meshes[0].primitives[1001]"),
    "glb with nodes 9,000 deep": (
        lambda: glb(GRID, nodes=[{"children": [i + 1]} for i in range(9000)] + [{"mesh": 0}]), "nodes[4000]"),
    "glb with a million copies": (
        lambda: glb(GRID[:1], scenes=[{"nodes": list(range(2000))}], nodes=[{"mesh": 0}] * 2000,
                     meshes=[{"primitives": [{"attributes": {"POSITION": 0}}] * 500}]),
        "meshes[0].primitives[0]"),
    "glb of 10^12 points": (lambda: _accessor(count=10**12), "file"),
    "glb of -1 points": (lambda: _accessor(count=-1), "accessors[0].count"),
    "glb of no points": (lambda: _accessor(count=0), "accessors[0]"),
    "glb of one point more": (lambda: _accessor(count=51), "accessors[0]"),
    "glb of 4 million points": (lambda: _accessor(count=4_000_000), "accessors[0]"),
    "glb with a far offset": (lambda: _accessor(byteOffset=2**40), "accessors[0]"),
    "glb with an offset below zero": (lambda: _accessor(byteOffset=-12), "accessors[0].byteOffset"),
    "glb with sparse points": (lambda: _accessor(sparse={"count": 2**31}), "accessors[0]"),
    "glb of strings": (lambda: _accessor(type="VEC3" * 1000), "accessors[0]"),
    "glb of doubles": (lambda: _accessor(componentType=5130), "accessors[0]"),
    "glb with a long view": (
        lambda: glb(GRID, bufferViews=[{"buffer": 0, "byteLength": 10**12}]), "accessors[0]"),
    "glb with a stride of 0": (
        lambda: glb(GRID, bufferViews=[{"buffer": 0, "byteLength": 600, "byteStride": 0}]), "accessors[0]"),
    "glb compressed by draco": (
        lambda: glb(GRID, extensionsUsed=["KHR_draco_mesh_compression"]), "extensionsUsed"),
}  # fmt: skip
CASES = {
    f"{family}: {name}": case
    for family, cases in {
        "not finite": NOT_FINITE, "json": JSON, "text": TEXT, "packed": PACKED, "mesh": MESHES,
    }.items()
    for name, case in cases.items()
}  # fmt: skip


# Values beside the points, in JSON.


def _options(**options: object) -> bytes:
    return json.dumps({**json.loads(REQUEST), "options": options}).encode()


def _per_point(name: str, value: float) -> bytes:
    points = json.loads(REQUEST)["points"]
    return json.dumps({"points": points, name: _array([1.0] * (len(points) - 1) + [value])}).encode()


SPHERE = {"kind": "sphere", "center": [0, 0, 0], "radius": 1}
VALUES: dict[str, tuple[Make, str]] = {
    "infinity in base64 weights": (lambda: _per_point("weights", np.inf), "weights[39]"),
    "NaN in base64 weights": (lambda: _per_point("weights", np.nan), "weights[39]"),
    "NaN in base64 deviations": (lambda: _per_point("standard_deviations", np.nan),
                                 "standard_deviations[39]"),
    "too few base64 weights": (lambda: _json(weights=_array([1.0])), "weights"),
    "1e999 in max_error": (lambda: _options(max_error=7).replace(b"7}", b"1e999}"), "options.max_error"),
    "NaN in a constraint": (lambda: _options(constraints={"radius": {"value": np.nan}}),
                            "options.constraints.radius.value"),
    "a huge constraint": (lambda: _options(constraints={"center": [1e308, 0, 0]}),
                          "options.constraints.center"),
    "NaN in a guess": (lambda: _options(initial_guess={**SPHERE, "radius": np.nan}),
                       "options.initial_guess.radius"),
    "190,000 unknown options": (
        lambda: _options(**{f"a{i}": 1 for i in range(190_000)}), "options"),
    "190,000 unknown constraints": (
        lambda: _options(constraints={f"a{i}": 1 for i in range(190_000)}), "options"),
    "a nominal of 100,000 values": (lambda: _options(nominal={"kind": [0] * 100_000}), "options"),
    "a guess of 5,000 digits": (lambda: _options(seed=7).replace(b"7}", b"7" * 5000 + b"}"), "options.seed"),
}  # fmt: skip


# Packed bodies, and uploads.


def upload(*parts: tuple[bytes, bytes]) -> bytes:
    """A multipart body of these headers and contents."""
    return b"".join(b"--x\r\n%s\r\n\r\n%s\r\n" % part for part in parts) + b"--x--\r\n"


def named_part(name: bytes, content: bytes = CSV) -> tuple[bytes, bytes]:
    return b'Content-Disposition: form-data; name="%s"; filename="a.csv"' % name, content


PACKED_BODIES: dict[str, tuple[str, str, Make, int, str]] = {
    "gzip bomb": ("gzip", "text/csv", lambda: gzip.compress(bytes(2**28)), 413, "body"),
    "gzip bomb of json": ("gzip", "application/json", lambda: gzip.compress(b" " * 2**28), 413, "body"),
    "zstd bomb": ("zstd", "text/csv", lambda: zstandard.compress(bytes(2**28)), 413, "body"),
    "bomb in an upload": ("gzip", "multipart/form-data; boundary=x",
                          lambda: gzip.compress(upload(named_part(b"file", bytes(2**28)))), 413, "body"),
    "bomb as a part": ("identity", "multipart/form-data; boundary=x",
                       lambda: upload(named_part(b"file", gzip.compress(bytes(2**28)))), 413, "file"),
    "gzip cut": ("gzip", "text/csv", lambda: gzip.compress(CSV)[:1000], 422, "body"),
    "zstd cut": ("zstd", "text/csv", lambda: zstandard.compress(CSV)[:1000], 422, "body"),
    "no gzip": ("gzip", "text/csv", lambda: CSV, 422, "body"),
    "no zstd": ("zstd", "text/csv", lambda: CSV, 422, "body"),
    "empty": ("gzip", "text/csv", lambda: b"", 422, "body"),
    "garbage after the end": ("gzip", "text/csv", lambda: gzip.compress(CSV) + b"1,2,3", 422, "body"),
    "a packed file in a packed body": (
        "gzip", "text/csv", lambda: gzip.compress(zstandard.compress(CSV)), 422, "file"),
    "a packed part in a packed body": (
        "zstd", "multipart/form-data; boundary=x",
        lambda: zstandard.compress(upload(named_part(b"file", gzip.compress(CSV)))), 422, "file"),
}  # fmt: skip
UPLOADS: dict[str, tuple[Make, str]] = {
    "a part with a path": (lambda: upload(named_part(b"../../etc/passwd")), "../../etc/passwd"),
    "a part of 300 characters": (lambda: upload(named_part(b"n" * 300)), "n" * 40),
    "a part without a name": (lambda: upload((b"Content-Disposition: form-data", CSV)), "body"),
    "a part without a header": (lambda: upload((b"", CSV)), "body"),
    "a NUL in a name": (lambda: upload(named_part(b"fi\0le")), "fi?le"),
    "a NUL in a header": (lambda: upload((b"Content\0Disposition: form-data", CSV)), "body"),
    "a header of 1 MB": (lambda: upload(named_part(b"n" * MIB)), "body"),
    "200,000 headers": (lambda: upload((b"\r\n".join([b"A: b"] * 200_000), CSV)), "body"),
    "200,000 parameters": (lambda: upload((named_part(b"file")[0] + b"; a=b" * 200_000, CSV)), "body"),
    "the file twice": (lambda: upload(named_part(b"file"), named_part(b"file")), "file"),
    "an unknown part": (lambda: upload(named_part(b"file"), named_part(b"color")), "color"),
    "100,000 parts": (lambda: upload(*[named_part(b"file", b"1")] * 100_000), "file"),
    "100,000 unknown parts": (lambda: upload(*[named_part(b"p", b"1")] * 100_000), "p"),
    "no end": (lambda: upload(named_part(b"file"))[:-6], "body"),
    "another boundary": (lambda: upload(named_part(b"file")).replace(b"--x", b"--y"), "body"),
    "options of 1 MB": (lambda: upload(named_part(b"file"), named_part(b"options", b" " * MIB)), "options"),
    "options 30,000 deep": (
        lambda: upload(named_part(b"file"), named_part(b"options", b"[" * 30_000)), "options"),
    "NaN in the options": (
        lambda: upload(named_part(b"file"), named_part(b"options", b'{"max_error": NaN}')), "options"),
}  # fmt: skip
BOUNDARIES = ("", "; boundary=", f"; boundary={'b' * 71}", "; boundary" * 1000)
QUERIES = {
    "max_error=nan": "max_error",
    "max_error=inf": "max_error",
    "max_error=1e999": "max_error",
    f"seed={'7' * 5000}": "seed",
}
"""Queries beside a CSV file, with the field that is refused."""
