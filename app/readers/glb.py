"""GLB (binary glTF 2.0): the vertices of its default scene, in the frame of the scene.

Own reader, not a library's: every count and offset has to be held against the bytes before anything is
allocated, which is most of the work; trimesh takes a second and 60 MB to import. Nothing outside the file is
ever opened, no image is decoded, and what a URI names is not read.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import orjson

from .cloud import Array, Cloud
from .columns import FOUND, Pick
from .errors import TooLargeError, UnreadableFileError, describe
from .limits import UNLIMITED, Limits
from .mesh import build_mesh

_JSON, _BIN = 0x4E4F534A, 0x004E4942
# The texts of scenes with hundreds of meshes are smaller; one of this size takes some 30 MB when parsed.
_JSON_LIMIT = 1024 * 1024
# Each takes a tenth of a millisecond, however few vertices it has.
_MOST_PARTS = 4000
# Vertices beyond those that fit into the bytes of the file: half a second of work for a sender who has none.
_MOST_COPIES = 500_000
_TYPES = {"5120": "<i1", "5121": "<u1", "5122": "<i2", "5123": "<u2", "5126": "<f4"}
_NOT_READ = (
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "EXT_mesh_gpu_instancing",
)


def read_glb(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read the distinct vertices of all meshes of the scene, moved by the transforms of their nodes."""
    document, buffer = _chunks(data)
    asset = _Asset(document, buffer)
    vertices: list[Array] = []
    normals: list[Array | None] = []
    n_vertices = n_bytes = 0
    with np.errstate(all="ignore"):  # what overflows is no longer finite, and refused for that
        for place, attributes, matrix in asset.parts():
            n_vertices += asset.count(place, attributes)
            limits.check_points(n_vertices)
            given, normal = asset.vectors(place, attributes["POSITION"]), attributes.get("NORMAL")
            n_bytes += asset.n_bytes(place, attributes)
            if n_vertices * (1.0 - len(buffer) / n_bytes) > _MOST_COPIES:
                message = f"the scene holds more than {_MOST_COPIES} copies of vertices, the limit"
                raise TooLargeError(place, message, f"{n_vertices} vertices")
            moved = not np.array_equal(matrix, np.eye(4))
            vertices.append(given @ matrix[:3, :3].T + matrix[:3, 3] if moved else given)
            turned = None if normal is None else asset.vectors(place, normal) @ _cofactors(matrix[:3, :3]).T
            normals.append(turned)
    points = np.vstack([np.empty((0, 3)), *vertices])
    return build_mesh(points, _joined(vertices, normals), "glb", limits, pick)


def _joined(vertices: list[Array], normals: list[Array | None]) -> Array | None:
    """All normals, or None where some vertices have none."""
    given = [normal for normal in normals if normal is not None]
    if not given or [len(array) for array in given] != [len(array) for array in vertices]:
        return None
    return np.vstack(given)


def _cofactors(matrix: Array) -> Array:
    """What normals are transformed by, up to length and sign: the cofactors."""
    return np.cross(matrix[[1, 2, 0]], matrix[[2, 0, 1]])


def _chunks(data: memoryview) -> tuple[dict[str, Any], memoryview]:
    """The document and the binary buffer, whose lengths add up to that of the file."""
    if len(data) < 20:
        raise UnreadableFileError("file", "the GLB file ends in its header")
    _, version, length = struct.unpack_from("<4sII", data)
    if version != 2:
        raise UnreadableFileError("header", "only version 2 of GLB is read")
    if length != len(data):
        raise UnreadableFileError(
            "header", f"a GLB file that announces {length} bytes, {len(data)} are there"
        )
    (kind, text), *rest = _cut(data)
    if kind != _JSON:
        raise UnreadableFileError("file", "the first chunk of the GLB file is not JSON")
    if len(text) > _JSON_LIMIT:
        raise UnreadableFileError("file", "the JSON of the GLB file is over 1 MiB long", f"{len(text)} bytes")
    try:
        document = orjson.loads(text)
    except orjson.JSONDecodeError:
        raise UnreadableFileError("file", "the JSON of the GLB file cannot be parsed") from None
    if not isinstance(document, dict):
        raise UnreadableFileError("file", "the JSON of the GLB file must be an object", describe(document))
    return document, next((chunk for kind, chunk in rest if kind == _BIN), memoryview(b""))


def _cut(data: memoryview) -> list[tuple[int, memoryview]]:
    """The first two chunks by their kind, or the only one."""
    chunks: list[tuple[int, memoryview]] = []
    start = 12
    while start < len(data) and len(chunks) < 2:
        size, kind = struct.unpack_from("<II", data, start) if start + 8 <= len(data) else (len(data), 0)
        start += 8 + size
        if start > len(data):
            raise UnreadableFileError("file", f"chunk {len(chunks)} of the GLB file is longer than the file")
        chunks.append((kind, data[start - size : start]))
    return chunks


@dataclass(frozen=True)
class _Asset:
    """A glTF document and its buffer; what is asked of it is checked first, and named where it is wrong."""

    document: dict[str, Any]
    buffer: memoryview

    def parts(self) -> Iterator[tuple[str, dict[str, Any], Array]]:
        """Each primitive of the scene: its place in the document, its attributes, its transform (4, 4)."""
        n_seen = 0
        for mesh, matrix in self._placed_meshes():
            item = self._item("meshes", mesh, "mesh")
            shared = set()
            for i, primitive in enumerate(_list(item, "primitives", f"meshes[{mesh}]")):
                place = f"meshes[{mesh}].primitives[{i}]"
                n_seen += 1
                _check_parts(n_seen, place)
                attributes = primitive.get("attributes") if isinstance(primitive, dict) else None
                if not isinstance(attributes, dict) or "POSITION" not in attributes:
                    raise UnreadableFileError(place, "it has no attribute POSITION")
                used = tuple(str(attributes.get(name)) for name in ("POSITION", "NORMAL"))
                if used not in shared:
                    shared.add(used)
                    yield place, attributes, matrix

    def _placed_meshes(self) -> Iterator[tuple[int, Array]]:
        """Each mesh of the default scene as often as it stands there, with its transform (4, 4)."""
        extensions = self.document.get("extensionsUsed")
        if isinstance(extensions, list) and (hidden := [name for name in _NOT_READ if name in extensions]):
            raise UnreadableFileError("extensionsUsed", f"{hidden[0]} is not read; export without it")
        scene = self._item("scenes", self.document.get("scene", 0), "scene")
        waiting = [(node, np.eye(4)) for node in reversed(_list(scene, "nodes", "scene"))]
        seen: set[int] = set()
        while waiting:
            index, above = waiting.pop()
            place = f"nodes[{index}]"
            node = self._item("nodes", index, "nodes")
            if index in seen:
                raise UnreadableFileError(place, "the node has more than one parent")
            seen.add(index)
            _check_parts(len(seen), place)
            matrix = above @ _transform(node, place)
            if "mesh" in node:
                yield node["mesh"], matrix
            waiting += [(child, matrix) for child in reversed(_list(node, "children", place))]

    def count(self, place: str, attributes: dict[str, Any]) -> int:
        """How many vertices a primitive has, the same in all its attributes."""
        position, normal = attributes["POSITION"], attributes.get("NORMAL")
        count = _whole(self._item("accessors", position, place), "count", f"accessors[{position}]")
        if normal is not None and self._item("accessors", normal, place).get("count") != count:
            raise UnreadableFileError(place, "POSITION and NORMAL differ in their count")
        return count

    def n_bytes(self, place: str, attributes: dict[str, Any]) -> int:
        """What the positions of a primitive take in the file if nothing else uses these bytes."""
        index = attributes["POSITION"]
        accessor, dtype = self._accessor(place, index, f"accessors[{index}]")
        return 3 * dtype.itemsize * int(accessor["count"])

    def vectors(self, place: str, index: int) -> Array:
        """The vectors (N, 3) of an accessor that lies inside the buffer of the file."""
        name = f"accessors[{index}]"
        accessor, dtype = self._accessor(place, index, name)
        view = self._item("bufferViews", accessor["bufferView"], name)
        view_name = f"bufferViews[{accessor['bufferView']}]"
        self._check_buffer(view, view_name)
        count, offset = _whole(accessor, "count", name), _whole(accessor, "byteOffset", name, 0)
        stride = _whole(view, "byteStride", view_name, 3 * dtype.itemsize)
        start = _whole(view, "byteOffset", view_name, 0)
        end = start + _whole(view, "byteLength", view_name)
        last = start + offset + stride * (count - 1) + 3 * dtype.itemsize
        if count < 1 or not 3 * dtype.itemsize <= stride <= 252 or last > end or end > len(self.buffer):
            raise UnreadableFileError(
                name, f"{count:.9g} vectors do not fit into the {len(self.buffer)} bytes of the buffer"
            )
        strides = (stride, dtype.itemsize)
        vectors = np.ndarray((count, 3), dtype, self.buffer, start + offset, strides).astype(np.float64)
        if dtype.kind == "f" or accessor.get("normalized") is not True:
            return vectors
        return np.maximum(vectors / np.iinfo(dtype).max, -1.0)

    def _accessor(self, place: str, index: int, name: str) -> tuple[dict[str, Any], np.dtype[Any]]:
        """An accessor of vectors, and the type of their numbers."""
        accessor = self._item("accessors", index, place)
        dtype = np.dtype(_TYPES.get(str(accessor.get("componentType")), "V"))
        if accessor.get("type") != "VEC3" or dtype.kind == "V":
            raise UnreadableFileError(name, "positions and normals must be VEC3 of floats or short integers")
        if "bufferView" not in accessor or "sparse" in accessor:
            raise UnreadableFileError(name, "the accessor is sparse or compressed, which is not read")
        return accessor, dtype

    def _check_buffer(self, view: dict[str, Any], name: str) -> None:
        buffer = self._item("buffers", view.get("buffer"), name)
        if view["buffer"] != 0 or "uri" in buffer:
            raise UnreadableFileError(name, "it lies outside the GLB file, where nothing is opened")

    def _item(self, name: str, index: object, asked_by: str) -> dict[str, Any]:
        """The object of this index in one of the arrays at the top of the document."""
        items = self.document.get(name)
        if not isinstance(items, list) or type(index) is not int or not 0 <= index < len(items):
            raise UnreadableFileError(asked_by, f"it refers to an item of {name} that is not there")
        if not isinstance(items[index], dict):
            raise UnreadableFileError(f"{name}[{index}]", "an object is needed", describe(items[index]))
        return items[index]


def _check_parts(n_parts: int, place: str) -> None:
    if n_parts > _MOST_PARTS:
        raise TooLargeError(place, f"the scene has more than {_MOST_PARTS} nodes or primitives, the limit")


def _list(item: dict[str, Any], key: str, name: str) -> list[Any]:
    values = item.get(key, [])
    if not isinstance(values, list):
        raise UnreadableFileError(f"{name}.{key}", "an array is needed", describe(values))
    return values


def _whole(item: dict[str, Any], key: str, name: str, default: int | None = None) -> int:
    value = item.get(key, default)
    if type(value) is not int or value < 0:
        raise UnreadableFileError(f"{name}.{key}", "a whole number, not negative, is needed", describe(value))
    return value


def _numbers(item: dict[str, Any], key: str, name: str, default: list[float]) -> Array:
    values = item.get(key, default)
    if (
        not isinstance(values, list)
        or len(values) != len(default)
        or not set(map(type, values)) <= {int, float}
    ):
        raise UnreadableFileError(f"{name}.{key}", f"{len(default)} numbers are needed", describe(values))
    return np.array(values, np.float64)


def _transform(node: dict[str, Any], name: str) -> Array:
    """The matrix (4, 4) of a node: as given, column by column, or of translation, rotation and scale."""
    if "matrix" in node:
        return _numbers(node, "matrix", name, [0.0] * 16).reshape(4, 4).T
    x, y, z, w = _numbers(node, "rotation", name, [0.0, 0.0, 0.0, 1.0])
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * _numbers(node, "scale", name, [1.0, 1.0, 1.0])
    matrix[:3, 3] = _numbers(node, "translation", name, [0.0, 0.0, 0.0])
    return matrix
