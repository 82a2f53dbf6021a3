"""NPZ: a ZIP archive of NPY arrays. Arrays alone are unpacked, one at a time, and never more than announced.

Which array holds the points: `points` or `xyz`, or the only one that can. `normals` and the labels may stand
beside them. The central directory is held against the bytes that are there before `zipfile` reads it.
"""

import io
import struct
import zlib
from dataclasses import replace
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo

import numpy as np

from .cloud import Array, Cloud, as_float, as_labels, unit_normals
from .columns import FOUND, Pick, find_label
from .errors import InvalidPointsError, UnreadableFileError
from .foreign import name_of_zip
from .formats import NAMES
from .limits import UNLIMITED, Limits
from .npy import HEADER_LIMIT, ArrayHeader, as_text, read_array, read_header, read_records, read_table

_END = struct.Struct("<4s4H2LH")
_END_MARK, _ZIP64_MARK = b"PK\x05\x06", b"PK\x06\x07"
_MEMBER_LIMIT = 100
# So many arrays are looked into to find the points, if none is named so.
_LOOKED_INTO = 16
_DIRECTORY_LIMIT = 64 * 1024
_DEFLATE_RATIO = 1032
_ENCRYPTED = 0x1
_POINTS = ("points", "xyz")
_NORMALS = ("nx", "ny", "nz")


def read_npz(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read the points of an NPZ file, with the normals and labels beside them."""
    if (name := name_of_zip(data)) is not None:
        raise UnreadableFileError("file", f"the file is {name}; what is read: {NAMES}")
    n_members = _check_directory(data)
    try:
        with ZipFile(io.BytesIO(data)) as archive:
            return _read(archive, _members(archive, n_members, len(data), limits), limits, pick)
    except UnreadableFileError:
        raise
    except (BadZipFile, zlib.error, struct.error, EOFError, NotImplementedError, ValueError) as error:
        raise UnreadableFileError("file", "the ZIP archive is damaged, or ends early") from error


def _check_directory(data: memoryview) -> int:
    """The number of members, from an end record that must be right behind its central directory."""
    if len(data) < _END.size or bytes(data[-_END.size :][:4]) != _END_MARK:
        raise UnreadableFileError("file", "the ZIP archive has a comment, or ends early")
    _, disk, first_disk, n_here, n_members, size, offset, comment = _END.unpack(data[-_END.size :])
    before = len(data) - _END.size
    if bytes(data[max(before - 20, 0) :][:4]) == _ZIP64_MARK:
        raise UnreadableFileError("file", "a ZIP archive with a ZIP64 directory; NPZ files need none")
    if (disk, first_disk, comment, n_here) != (0, 0, 0, n_members) or offset + size != before:
        raise UnreadableFileError("file", "the directory of the ZIP archive does not agree with its bytes")
    if n_members > _MEMBER_LIMIT or size > _DIRECTORY_LIMIT:
        limit = f"at most {_MEMBER_LIMIT} in a directory of 64 KiB are read"
        raise UnreadableFileError("file", f"the ZIP archive announces {n_members} members; {limit}")
    return n_members


def _members(archive: ZipFile, n_members: int, there: int, limits: Limits) -> dict[str, ZipInfo]:
    """The arrays of the archive by their names; sizes that cannot be true are refused."""
    infos = archive.infolist()
    if len(infos) != n_members or sum(info.compress_size for info in infos) > there:
        raise UnreadableFileError("file", "the members of the ZIP archive do not agree with its bytes")
    arrays = [info for info in infos if info.filename.endswith(".npy")]
    for info in arrays:
        _check_member(info, limits)
    members = {info.filename.removesuffix(".npy"): info for info in arrays}
    if len(members) != len(arrays):
        raise UnreadableFileError("file", "two members of the ZIP archive have the same name")
    return members


def _check_member(info: ZipInfo, limits: Limits) -> None:
    if info.flag_bits & _ENCRYPTED:
        raise UnreadableFileError("file", "the ZIP archive is encrypted")
    if info.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
        raise UnreadableFileError("file", "the ZIP archive is packed by another method than NumPy's")
    limits.check_unpacked(info.file_size, info.compress_size)
    stored = info.compress_type == ZIP_STORED
    if info.file_size > info.compress_size * (1 if stored else _DEFLATE_RATIO):
        raise UnreadableFileError("file", "a member of the ZIP archive announces more than it can hold")


def _read(archive: ZipFile, members: dict[str, ZipInfo], limits: Limits, pick: Pick) -> Cloud:
    name = _name_of_points(archive, members)
    points = _array(archive, members[name], limits, points=True)
    if points.dtype.names is not None:
        return read_records(points, "npz", pick)
    cloud = read_table(points, "npz", replace(pick, labels=None))
    if "normals" in members and pick.columns is None:
        normals = _beside(archive, members["normals"], limits, (*points.shape[:-1], 3)).reshape(-1, 3)
        cloud = _with_normals(cloud, as_float(normals, "normals"))
    names = list(members)
    label = find_label(names, pick.labels)
    if label is None:
        return cloud
    labels = _beside(archive, members[names[label]], limits, points.shape[:-1]).reshape(-1)
    return replace(cloud, labels=as_labels(labels, cloud.points), label_column=names[label][:40])


def _with_normals(cloud: Cloud, given: Array) -> Cloud:
    normals = unit_normals(given, cloud.points)
    return cloud if normals is None else replace(cloud, normals=normals, columns=(*cloud.columns, *_NORMALS))


def _name_of_points(archive: ZipFile, members: dict[str, ZipInfo]) -> str:
    """Which array holds the points; none or several are refused."""
    if not members:
        message = "a ZIP archive without arrays; unpack it, and send the file that holds the points"
        raise UnreadableFileError("file", message)
    found = [name for name in _POINTS if name in members]
    if not found:
        others = [name for name in members if name != "normals"]
        if len(others) > _LOOKED_INTO:
            message = f"an NPZ file of {len(members)} arrays, none of them named points or xyz; name one so"
            raise UnreadableFileError("file", message)
        found = [name for name in others if _may_be_points(_head(archive, members[name])[1])]
    if len(found) == 1:
        return found[0]
    many = f"{len(found)} arrays may be" if found else f"none of its {len(members)} arrays can be"
    raise UnreadableFileError("file", f"an NPZ file, but {many} the points; name one of them points")


def _may_be_points(header: ArrayHeader) -> bool:
    try:
        header.check_points()
    except InvalidPointsError:
        return False
    return True


def _head(archive: ZipFile, member: ZipInfo) -> tuple[bytes, ArrayHeader]:
    """The first bytes of a member, and the header in them."""
    with archive.open(member) as stream:
        head = stream.read(HEADER_LIMIT + 12)
    return head, read_header(memoryview(head))


def _array(archive: ZipFile, member: ZipInfo, limits: Limits, points: bool = False) -> np.ndarray:
    """Unpack one array, whose size its header and the directory agree on."""
    _, header = _head(archive, member)
    if points:
        header.check_points()
    header.check(limits)
    if header.end != member.file_size:
        needed, there = header.end - header.start, member.file_size - header.start
        raise UnreadableFileError("file", f"the header announces {needed} bytes of data, {there} are there")
    with archive.open(member) as stream:
        data = stream.read(header.end + 1)
    return read_array(memoryview(data), header)


def _beside(archive: ZipFile, member: ZipInfo, limits: Limits, shape: tuple[int, ...]) -> np.ndarray:
    array = _array(archive, member, limits)
    if array.shape != shape:
        name = member.filename.removesuffix(".npy")[:40]
        message = f"array of shape {as_text(array.shape)}; beside the points it must be {as_text(shape)}"
        raise InvalidPointsError(name, message)
    return array
