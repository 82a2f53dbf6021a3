"""E57, by pye57, which the extra `e57` brings: the points of all scans, in the frame of the file.

Coordinates of a scan are cartesian, or else spherical: a range, an azimuth and an elevation in radians.

The header, the place of the XML section and what it may do to its parser are checked before libE57 opens the
file, and the records are read piece by piece, so that a count costs nothing until its points are there.
"""

import struct
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from typing import Any
from xml.parsers import expat

import numpy as np

from .cloud import Array, Cloud, as_labels, build_cloud
from .columns import FOUND, Columns, Pick, find_label
from .errors import TooLargeError, UnreadableFileError
from .limits import UNLIMITED, Limits
from .missing import repeated_zeros
from .rows import check_bytes

_HEADER = struct.Struct("<8x2L4Q")
_PAGE, _CHECKSUM = 1024, 4
_XML_LIMIT = 1024 * 1024
_DEPTH_LIMIT = 64
# libE57 compares each element with all that stand beside it.
_CHILDREN_LIMIT = 1000
_CHUNK = 50_000
_CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
_SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
# Each with the field that says which points are not measured, where that is not 0.
_SYSTEMS: dict[tuple[str, ...], str] = {
    _CARTESIAN: "cartesianInvalidState",
    _SPHERICAL: "sphericalInvalidState",
}


def read_e57(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read the valid points of all scans of an E57 file, each moved by its pose."""
    try:
        import pye57
    except ImportError:
        message = "E57 is read where primfit is installed with its extra e57, which is missing here"
        raise UnreadableFileError("file", message) from None
    _check_xml(_xml(data))
    with _as_file(data) as path:
        try:
            with pye57.E57(path) as file:
                return _read(file, len(data), limits, pick)
        except UnreadableFileError:
            raise
        except Exception as error:  # libE57, its binding and NumPy have no common class of errors
            raise UnreadableFileError(
                "file", "the E57 file is damaged, or of an unusual structure"
            ) from error


@contextmanager
def _as_file(data: memoryview) -> Iterator[str]:
    """The path of a file that holds the data: libE57 reads nothing else.

    On Linux it has no name of its own, so nothing is left of it where the process is killed meanwhile.
    """
    if sys.platform == "linux":
        with TemporaryFile() as file:
            file.write(data)
            file.flush()
            yield f"/proc/self/fd/{file.fileno()}"
    else:
        with TemporaryDirectory() as folder:
            path = Path(folder, "cloud.e57")
            path.write_bytes(data)
            yield str(path)


def _xml(data: memoryview) -> bytes:
    """The XML section, of pages whose checksums libE57 holds against them."""
    if len(data) < _HEADER.size:
        raise UnreadableFileError("header", "the file ends within the E57 header")
    major, _, n_bytes, start, length, page = _HEADER.unpack(data[: _HEADER.size])
    if major != 1 or page != _PAGE:
        raise UnreadableFileError(
            "header", "E57 of another version than 1, or of other pages than of 1024 bytes"
        )
    if n_bytes != len(data) or n_bytes % _PAGE:
        raise UnreadableFileError("file", f"the header announces {n_bytes} bytes, {len(data)} are there")
    if length > _XML_LIMIT:
        raise UnreadableFileError("header", f"the XML section has {length} bytes; the limit is {_XML_LIMIT}")
    first, offset = divmod(start, _PAGE)
    last = first - (-(offset + length) // (_PAGE - _CHECKSUM))
    pages = np.frombuffer(data, np.uint8).reshape(-1, _PAGE)[first:last, :-_CHECKSUM]
    section = pages.tobytes()[offset : offset + length]
    if len(section) < length:
        raise UnreadableFileError("file", "the XML section does not lie in the E57 file")
    return section


def _check_xml(section: bytes) -> None:
    """Raise where the XML is broken, defines entities, which may multiply, or is nested too deep or wide."""
    n_children = [0]  # of the document, and of each element that is open

    def enter(*_: object) -> None:
        n_children[-1] += 1
        n_children.append(0)
        if len(n_children) > 1 + _DEPTH_LIMIT:
            raise UnreadableFileError("file", f"the XML section is nested over {_DEPTH_LIMIT} deep")
        if n_children[-2] > _CHILDREN_LIMIT:
            message = f"an element of the XML section holds over {_CHILDREN_LIMIT} others, the limit"
            raise TooLargeError("file", message)

    def leave(_: object) -> None:
        n_children.pop()

    def refuse(*_: object) -> None:
        raise UnreadableFileError("file", "the XML section has a document type; E57 has none")

    parser = expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = enter, leave
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(section.rstrip(b" \0\n"), True)
    except UnreadableFileError:
        raise
    except (expat.ExpatError, LookupError, ValueError) as error:  # the last two: an unknown encoding
        raise UnreadableFileError("file", "the XML section cannot be parsed") from error


def _read(file: Any, n_bytes: int, limits: Limits, pick: Pick) -> Cloud:
    scans = [scan for scan in file.data3d if scan.isDefined("points")]
    if not scans:
        raise UnreadableFileError("file", "the E57 file holds no scan with points")
    n_points = sum(scan["points"].childCount() for scan in scans)
    limits.check_points(n_points)
    if pick.columns is not None:
        raise UnreadableFileError("columns", "the coordinates of an E57 file have names: nothing to choose")
    fields = [_fields(scan) for scan in scans]
    systems = [_system(names, number) for number, names in enumerate(fields, 1)]
    # No two scans share their bytes.
    check_bytes(sum(map(_least_size, scans, systems)), n_bytes, n_points)
    common = [name for name in fields[0] if all(name in names for names in fields)]
    label = find_label(common, pick.labels)
    beside = () if label is None else (common[label],)
    tables, invalid = [], 0
    for scan, system in zip(scans, systems, strict=True):
        table, n_invalid = _scan(file, scan, system, beside)
        tables.append(table)
        invalid += n_invalid
    table = np.concatenate(tables)
    columns = Columns(systems[0], (0, 1, 2), label_name=None if label is None else common[label][:40])
    found = None if label is None else as_labels(table[:, 3], table[:, :3])
    return replace(build_cloud(table, columns, "e57", found), dropped={"not_finite": invalid})


def _fields(scan: Any) -> list[str]:
    """The fields that the points of a scan have."""
    from pye57.libe57 import StructureNode

    return [node.elementName() for node in StructureNode(scan["points"].prototype())]


def _system(names: list[str], number: int) -> tuple[str, ...]:
    """The coordinates among the fields of a scan, cartesian ones where there are both."""
    found = next((system for system in _SYSTEMS if set(system) <= set(names)), None)
    if found is None:
        message = f"scan {number} of the E57 file holds neither cartesian nor spherical coordinates"
        raise UnreadableFileError("file", message)
    return found


def _least_size(scan: Any, system: tuple[str, ...]) -> int:
    """The bytes that the coordinates of a scan take at least."""
    from pye57.libe57 import StructureNode

    prototype = StructureNode(scan["points"].prototype())
    n_bits = sum(_bits(prototype[name]) for name in system)
    return int(scan["points"].childCount()) * max(n_bits, 1) // 8


def _scan(file: Any, scan: Any, system: tuple[str, ...], beside: tuple[str, ...]) -> tuple[Array, int]:
    """The valid points of a scan, moved by its pose, and what stands `beside` them; how many are invalid."""
    from pye57.libe57 import SourceDestBuffer, StructureNode, VectorSourceDestBuffer

    records = scan["points"]
    n_points = records.childCount()
    prototype = StructureNode(records.prototype())
    state = _SYSTEMS[system]
    fields = (*system, *beside, state) if prototype.isDefined(state) else (*system, *beside)
    buffer = np.empty((len(fields), max(min(n_points, _CHUNK), 1)))
    buffers = VectorSourceDestBuffer()
    for name, values in zip(fields, buffer, strict=True):
        buffers.append(SourceDestBuffer(file.image_file, name, values, len(values), True, True))
    parts = [np.empty((0, len(fields)))]
    reader = records.reader(buffers)
    while sum(map(len, parts)) < n_points and (n_read := reader.read()):
        parts.append(buffer[:, :n_read].T.copy())
    reader.close()
    table = np.concatenate(parts)
    if len(table) != n_points:
        raise UnreadableFileError("file", f"a scan announces {n_points} points, {len(table)} are there")
    if fields[-1] == state:
        table = table[table[:, -1] == 0.0, :-1]
    points = table[:, :3] if system == _CARTESIAN else _to_cartesian(table[:, :3])
    zero = repeated_zeros(points)
    table[:, :3] = _move(points, scan)
    if zero is not None:  # the pose would hide them at the scanner's position
        table[zero, :3] = 0.0
    return table, n_points - len(table)


def _to_cartesian(points: Array) -> Array:
    """Range, azimuth and elevation (N, 3) as x, y, z (ASTM E2807)."""
    distance, azimuth, elevation = points.T
    with np.errstate(invalid="ignore"):
        level = distance * np.cos(elevation)
        return np.column_stack(
            [level * np.cos(azimuth), level * np.sin(azimuth), distance * np.sin(elevation)]
        )


def _bits(node: Any) -> int:
    """How many bits a value of this field takes at least."""
    from pye57.libe57 import FloatNode, FloatPrecision

    if isinstance(node, FloatNode):
        return 32 if node.precision() == FloatPrecision.E57_SINGLE else 64
    return int(node.maximum() - node.minimum()).bit_length()


def _move(points: Array, scan: Any) -> Array:
    """Points in the frame of the file: rotated by the quaternion of the pose, then shifted."""
    from scipy.spatial.transform import Rotation

    if not scan.isDefined("pose"):
        return points
    pose = scan["pose"]
    if pose.isDefined("rotation"):
        turn = [pose["rotation"][name].value() for name in "xyzw"]
        if turn != [0.0, 0.0, 0.0, 1.0]:
            points = Rotation.from_quat(turn).apply(points)
    if pose.isDefined("translation"):
        points = points + [pose["translation"][name].value() for name in "xyz"]
    return points
