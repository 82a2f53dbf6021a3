"""Small, good inputs of each target, written by other libraries than those under test."""

import gzip
import json

import numpy as np
import trimesh
import zstandard

from tests.app.hostile.bodies import PTX_POSE, glb, named_part, upload
from tests.app.readers.written import POINTS, e57, las, laz, npy, npz, pcd, ply, records
from tests.paths import EXAMPLES

FEW = POINTS[:5]
CSV = b"x,y,z,nx,ny,nz,label\n0.5,1,2,0,0,1,a\n1,2.5e0,3,0,0,1,b\n4,4,nan,0,1,0,b\n"
_LABELS = np.arange(5, dtype="i4")
_FACES = np.array([([0, 1, 2],), ([0, 2, 3],)], dtype=[("vertex_indices", "i4", (3,))])


def _mesh(kind: str) -> bytes:
    exported = trimesh.creation.box().export(file_type=kind)
    return exported if isinstance(exported, bytes) else exported.encode()


def _json(**beside: object) -> bytes:
    return json.dumps({"points": FEW.tolist(), **beside}).encode()


def _plys() -> list[bytes]:
    vertices = (records(FEW, label=_LABELS), "vertex")
    faces = (_FACES, "face")
    return [
        ply(vertices),
        ply(vertices, faces),
        ply(faces, vertices, order=">"),
        ply(vertices, faces, text=True),
    ]


TEXTS = [
    CSV,
    b"# x y z\n1 2 3\n4 5 6\n7 8 9.5\n",
    b"3\n1 2 3 10 0 0 0\n4 5 6 10 0 0 0\n7 8 9 10 0 0 0\n",
    b'sep=;\nx [mm];y [mm];z [mm]\n1,5;2,5;3,5\n"4,0";;6\n',
    b"id\tE\tN\tH\n1\t2.5\t3\t4\n2\t3.5\t4\t5\n",
    b"1,2,3,4\r\n1.D+01 -nan(ind) 3 4\r\n% end\r\n",
]
PTX = b"2\n1\n" + PTX_POSE + b"1 2 3 0.5\n0 0 0 0.5\n"
SEEDS: dict[str, list[bytes]] = {
    "text": TEXTS,
    "ply": _plys(),
    "pcd": [pcd(FEW, encoding, label=_LABELS) for encoding in ("ascii", "binary", "binary_compressed")],
    "las": [las(FEW), laz(FEW), laz(FEW, version="1.2", format=1), las(FEW, segment=_LABELS)],
    "e57": [e57(FEW), e57(FEW, FEW, kind="scaled", pose=[1, 0, 0, 0, 1, 2, 3])],
    "npy": [npy(FEW), npy(FEW.astype("f4").reshape(1, 5, 3)), npy(records(FEW, label=_LABELS))],
    "npz": [npz(points=FEW, normals=FEW, labels=_LABELS), npz(False, xyz=FEW)],
    "glb": [glb(FEW), _mesh("glb")],
    "obj": [_mesh("obj"), b"v 1 2 3\nvn 0 0 1\nv 4 5 6\nvn 0 0 1\nf 1//1 2//2\n"],
    "stl": [_mesh("stl"), _mesh("stl_ascii")],
    "ptx": [PTX, PTX * 2],
    "json": [
        _json(normals=FEW.tolist(), labels=["a"] * 5, weights=[1.0] * 5),
        _json(options={"kinds": ["plane"], "nominal": {"kind": "sphere", "radius": {"value": 1}}}),
        (EXAMPLES / "request_base64.json").read_bytes(),
        b'{"points": [[1, 2, NaN], [1, -Infinity, 3]]}',
    ],
    "packed": [gzip.compress(CSV), zstandard.compress(CSV) * 2],
    "multipart": [
        b"multipart/form-data; boundary=x\n"
        + upload(named_part(b"file", CSV), named_part(b"options", b'{"kinds": ["plane"]}')),
    ],
    "options": [
        b"kinds=plane&columns=1,2,3&max_error=0.1&seed=7&include=",
        b'\n{"constraints": {"radius": {"min": 1}, "axis": {"direction": [0, 0, 1]}}, "criterion": "robust"}',
        b'\n{"initial_guess": {"kind": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]}, "tolerance": 1}',
    ],
    "any": [CSV, b"OFF\n3 0 0\n1 2 3\n", "\ufeffx y z\n1 2 3\n".encode("utf-16-le"), gzip.compress(TEXTS[1])],
}
