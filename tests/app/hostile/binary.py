"""Binary files that lie, never end, unpack without end or hide code."""

import io
import struct
import warnings
import zipfile
import zlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import lzf
import numpy as np

from tests.app.readers.written import POINTS, e57, las, laz, npy, npz, pcd, ply, records

COUNTS = {"10^12": 10**12, "5*10^7": 5 * 10**7, "2^32-1": 2**32 - 1, "one more": 61, "one fewer": 59}
BITS_32 = {name: count for name, count in COUNTS.items() if count < 2**32}
NOT_FINITE = {"nan": np.nan, "infinity": np.inf, "minus infinity": -np.inf}
Cases = Iterator[tuple[str, bytes]]


def patch(data: bytes, place: int, format: str, *values: float) -> bytes:
    """Other numbers at this place."""
    return data[:place] + struct.pack(format, *values) + data[place + struct.calcsize(format) :]


def spoilt(value: float, column: int = 1) -> np.ndarray:
    """The points with one coordinate that is no number."""
    points = POINTS.copy()
    points[17, column] = value
    return points


def cut(name: str, data: bytes, places: dict[str, int]) -> Cases:
    """The file, ended at each of these places."""
    for what, place in places.items():
        assert 0 < place < len(data)
        yield f"{name} cut {what}", data[:place]


# NPY --------------------------------------------------------------------------------------------------------


def npy_header(shape: Any, descr: Any = "<f8", version: int = 1) -> bytes:
    text = f"{{'descr': {descr!r}, 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    length = struct.pack("<H" if version == 1 else "<L", len(text))
    return b"\x93NUMPY" + bytes([version, 0]) + length + text


class Canary:
    """Unpickling one leaves a file behind."""

    path = Path(__file__).with_name("canary-was-run")

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.path,)


def npy_cases() -> Cases:
    data = npy(POINTS)
    start = len(data) - POINTS.nbytes
    for name, count in {**COUNTS, "-1": -1}.items():
        yield f"npy of {name} points", npy_header((count, 3)) + POINTS.tobytes()
    yield "npy of 2^63 columns", npy_header((60, 2**63)) + POINTS.tobytes()
    yield "npy of 10^6 dimensions", npy_header((1,) * 10**4) + POINTS.tobytes()
    yield "npy with a shape of text", npy_header("'60, 3'") + POINTS.tobytes()
    yield "npy with an endless header", b"\x93NUMPY\x02\x00\xff\xff\xff\x7f" + b" " * 2**20
    yield "npy with a nested header", b"\x93NUMPY\x01\x00\xff\xff" + b"{[" * 2**15
    yield "npy of version 9", b"\x93NUMPY\x09\x00" + data[8:]
    yield "npy of objects", npy(np.array([[1, 2, Canary()]], dtype=object), allow_pickle=True)
    yield "npy of records with objects", npy_header((60,), [("x", "|O")]) + POINTS.tobytes()
    yield "npy of elements without bytes", npy_header((60,), [("x", "|V0")])
    yield "npy of empty records", npy_header((60,), [])
    yield "a pickle", b"\x80\x04\x95" + bytes(64)
    yield "npy of 400,000 columns", npy_header((17, 400_000), "|i1") + bytes(17 * 400_000)
    name = "(" * 60_000 + "\n x"
    named = repr({"descr": [(name, "<f8")], "fortran_order": False, "shape": (1,)}).encode()
    yield (
        "npy with a name of brackets",
        b"\x93NUMPY\x02\x00" + struct.pack("<L", len(named)) + named + bytes(8),
    )
    places = {"in the magic": 4, "in the length": 9, "in the header": 40, "at the data": start}
    yield from cut("npy", data, {**places, "in the data": start + 100, "before the last byte": len(data) - 1})
    for name, value in NOT_FINITE.items():
        yield f"npy with {name}", npy(spoilt(value))


# NPZ --------------------------------------------------------------------------------------------------------


def zipped(members: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return stream.getvalue()


def with_sizes(data: bytes, packed: int | None, unpacked: int) -> bytes:
    """A ZIP archive of one member that claims these sizes in both of its headers."""
    directory = data.index(b"PK\x01\x02")
    packed = struct.unpack_from("<L", data, directory + 20)[0] if packed is None else packed
    return patch(patch(data, 18, "<2L", packed, unpacked), directory + 20, "<2L", packed, unpacked)


@cache
def zeros(n_bytes: int) -> bytes:
    """So many zeros, deflated, without ever holding them."""
    packer, parts = zlib.compressobj(9, zlib.DEFLATED, -15), []
    for _ in range(n_bytes // 2**20):
        parts.append(packer.compress(bytes(2**20)))
    return b"".join([*parts, packer.flush()])


def bomb(head: bytes, n_bytes: int, claimed: int) -> bytes:
    """An archive whose member unpacks to `head` and so many zeros, and claims fewer bytes."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    packed = packer.compress(head) + packer.flush(zlib.Z_FULL_FLUSH) + zeros(n_bytes)
    name = b"points.npy"
    local = struct.pack("<4s5H3L2H", b"PK\x03\x04", 20, 0, 8, 0, 0, 0, len(packed), claimed, len(name), 0)
    sizes = (0, len(packed), claimed, len(name), 0, 0, 0, 0, 0, 0)
    central = struct.pack("<4s6H3L5H2L", b"PK\x01\x02", 20, 20, 0, 8, 0, 0, *sizes)
    offset = len(local) + len(name) + len(packed)
    end = struct.pack("<4s4H2LH", b"PK\x05\x06", 0, 0, 1, 1, len(central) + len(name), offset, 0)
    return local + name + packed + central + name + end


def npz_cases() -> Cases:
    data = npz(points=POINTS)
    plain = zipped({"points.npy": npy(POINTS)}, zipfile.ZIP_STORED)
    end, directory = len(data) - 22, data.index(b"PK\x01\x02")
    for name, count in {**COUNTS, "-1": -1}.items():
        yield f"npz of {name} points", zipped({"points.npy": npy_header((count, 3)) + POINTS.tobytes()})
    yield "npz claiming 65,535 members", patch(data, end + 8, "<2H", 65535, 65535)
    yield "npz claiming no members", patch(data, end + 8, "<2H", 0, 0)
    yield "npz claiming a directory of 4 GB", patch(data, end + 12, "<L", 2**32 - 1)
    yield "npz with a directory that starts elsewhere", patch(data, end + 16, "<L", 0)
    yield "npz of many disks", patch(data, end + 4, "<2H", 7, 7)
    yield "npz of 30,000 members", zipped({f"{i}.npy": b"" for i in range(30_000)})
    yield "npz with long names", zipped({f"{i}" * 60_000: b"" for i in range(3)})
    yield "npz with a comment", data[:-2] + b"\x05\x00hello"
    locator = b"PK\x06\x07" + bytes(16)
    zip64 = patch(data, end + 16, "<L", directory)
    yield "npz with a ZIP64 directory", zip64[:end] + locator + zip64[end:]
    yield "npz encrypted", patch(data, directory + 8, "<H", 1)
    yield "npz packed by bzip2", zipped({"points.npy": npy(POINTS)}, zipfile.ZIP_BZIP2)
    yield "npz packed by lzma", zipped({"points.npy": npy(POINTS)}, zipfile.ZIP_LZMA)
    yield "npz in an npz", zipped({"points.npy": data})
    long = b"\x93NUMPY\x02\x00" + struct.pack("<L", 64_000) + (b"{'shape': (" + b"1," * 31_000).ljust(64_000)
    yield "npz of 100 long headers", zipped({f"{i}.npy": long for i in range(100)})
    yield "npz of 16 long headers", zipped({f"{i}.npy": long for i in range(16)})
    yield (
        "npz of 400,000 columns",
        zipped({"xyz.npy": npy_header((17, 400_000), "|i1") + bytes(17 * 400_000)}),
    )
    yield "npz of a million zeros", npz(points=np.zeros((10**6, 3)))
    yield "npz of a csv", zipped({"points.csv": b"1,2,3\n"})
    yield "npz claiming 4 GB", with_sizes(plain, None, 2**32 - 2)
    yield "npz stored, claiming more", with_sizes(plain, None, 2**20)
    yield (
        "npz claiming more than deflate reaches",
        with_sizes(zipped({"points.npy": npy(POINTS)}), None, 2**25),
    )
    yield "npz claiming a longer member than there is", with_sizes(plain, 2**20, 2**20)
    with warnings.catch_warnings(action="ignore"):
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w") as archive:
            archive.writestr("points.npy", npy(POINTS))
            archive.writestr("points.npy", npy(POINTS))
    yield "npz with one name twice", stream.getvalue()
    yield (
        "npz with a wrong checksum",
        patch(patch(plain, 14, "<L", 7), plain.index(b"PK\x01\x02") + 16, "<L", 7),
    )
    yield "npz with damaged data", plain[:300] + bytes(8) + plain[308:]
    yield "npz with a member elsewhere", patch(data, directory + 42, "<L", 2**31)
    yield "npz bomb that says so", bomb(npy_header((2**22, 3)), 96 * 2**20, 96 * 2**20 + 80)
    small = npy_header((60, 3))
    yield "npz bomb that claims 60 points", bomb(small, 128 * 2**20, len(small) + 60 * 24)
    yield "npz bomb in the header", bomb(b"\x93NUMPY\x02\x00\xff\xff\xff\x0f", 128 * 2**20, 32 * 2**20)
    yield "npz of objects", npz(points=np.array([[1, 2, Canary()]], dtype=object))
    yield "npz of objects alone", npz(a=np.array([Canary()], dtype=object))
    yield "npz of a pickle", zipped({"points.npy": b"\x80\x04\x95" + bytes(64)})
    yield "npz of no members", zipped({})
    places = {"in the first header": 20, "at the data": 46, "in the data": 400, "at the directory": directory}
    yield from cut("npz", data, {**places, "at the end record": end, "before the last byte": len(data) - 1})
    for name, value in NOT_FINITE.items():
        yield f"npz with {name}", npz(points=spoilt(value))


# PLY --------------------------------------------------------------------------------------------------------


def ply_cases() -> Cases:
    vertices = (records(POINTS), "vertex")
    faces = np.array([([0, 1, 2],), ([0, 2, 3],)], dtype=[("vertex_indices", "i4", (3,))])
    data, text = ply(vertices), ply(vertices, text=True)
    for name, count in {**COUNTS, "-1": -1}.items():
        wanted = b"vertex %d" % count
        yield f"ply of {name} points", data.replace(b"vertex 60", wanted)
        yield f"ply ascii of {name} points", text.replace(b"vertex 60", wanted)
    first = ply((faces, "face"), vertices)
    start = first.index(b"end_header\n") + 11
    for name, count in (("10^12", 10**12), ("2^32-1", 2**32 - 1), ("-1", -1)):
        yield f"ply of {name} faces before", first.replace(b"face 2", b"face %d" % count)
    listed = first.replace(b"list uchar", b"list int")
    listed = listed[:start] + bytes(3) + listed[start:]
    for name, count in (("-1", -1), ("2^31-1", 2**31 - 1)):
        yield f"ply with a list of {name}", patch(listed, listed.index(b"end_header\n") + 11, "<i", count)
    listed = text.replace(b"vertex 60\n", b"vertex 60\nproperty list int int l\n")
    for name, length in (("10^9", b"999999999"), ("10^12", b"1000000000000"), ("-1", b"-1"), ("pi", b"3.14")):
        yield (
            f"ply ascii with a list of {name}",
            listed.replace(b"end_header\n", b"end_header\n" + length + b" "),
        )
    header = b"ply\nformat binary_little_endian 1.0\nelement face %d\n%bend_header\n"
    uneven = header % (2 * 10**6, b"property list uchar uchar l\nelement vertex 1\nproperty float x\n")
    xyz = b"property float y\nproperty float z\nend_header\n"
    uneven = uneven.replace(b"end_header\n", xyz) + bytes([0, 1, 7]) * 10**6 + bytes(12)
    yield "ply with two million lists of two lengths", uneven
    yield (
        "ply with ten lists a row",
        uneven.replace(b"property list", b"property list uchar uchar l\n" * 9 + b"property list"),
    )
    yield "ply with an endless header", data[:10] + b"comment a\n" * 10**5
    yield "ply with an endless line", data[:10] + b"comment " + b"a" * 10**6
    yield "ply with 10^5 properties", data.replace(b"property", b"property float a\nproperty" * 10**4)
    end = data.index(b"end_header\n") + 11
    places = {"in the first line": 5, "in the header": 60, "at the data": end, "in the data": end + 100}
    yield from cut("ply", data, {**places, "before the last byte": len(data) - 1})
    yield from cut(
        "ply ascii", text, {"at the data": text.index(b"end_header\n") + 11, "in a row": len(text) - 30}
    )
    for name, value in NOT_FINITE.items():
        yield f"ply with {name}", ply((records(spoilt(value)), "vertex"))
        yield f"ply ascii with {name}", ply((records(spoilt(value)), "vertex"), text=True)


# PCD --------------------------------------------------------------------------------------------------------


def pcd_claiming(data: bytes, count: int) -> bytes:
    return data.replace(b"WIDTH 60", b"WIDTH %d" % count).replace(b"POINTS 60", b"POINTS %d" % count)


def pcd_packed(packed: bytes, n_packed: int, n_unpacked: int, count: int = 60) -> bytes:
    head = pcd(POINTS).partition(b"DATA")[0] + b"DATA binary_compressed\n"
    return pcd_claiming(head, count) + struct.pack("<2L", n_packed, n_unpacked) + packed


def pcd_cases() -> Cases:
    for encoding in ("ascii", "binary", "binary_compressed"):
        data = pcd(POINTS, encoding)
        for name, count in {**COUNTS, "-1": -1, "no": 0}.items():
            yield f"pcd {encoding} of {name} points", pcd_claiming(data, count)
        start = data.index(b"DATA") + len(encoding) + 6
        places = {"in the header": 50, "before DATA": data.index(b"DATA"), "at the data": start}
        yield from cut(f"pcd {encoding}", data, {**places, "in the data": start + 300})
        if encoding != "ascii":  # there the last byte ends a line
            yield from cut(f"pcd {encoding}", data, {"before the last byte": len(data) - 1})
        for name, value in NOT_FINITE.items():
            yield f"pcd {encoding} with {name}", pcd(spoilt(value), encoding)
    data = pcd(POINTS)
    yield "pcd of other points than its width", data.replace(b"WIDTH 60", b"WIDTH 61")
    yield "pcd with points of 10^9 values", data.replace(b"COUNT 1", b"COUNT 1000000000")
    yield "pcd with fields of no values", data.replace(b"COUNT 1", b"COUNT 0")
    yield "pcd with numbers of 3 bytes", data.replace(b"SIZE 8", b"SIZE 3")
    yield "pcd of another type", data.replace(b"TYPE F", b"TYPE X")
    yield "pcd with one type too few", data.replace(b"TYPE F", b"TYPE")
    yield "pcd without fields", data.replace(b"FIELDS x y z\n", b"")
    yield "pcd with fields twice", data.replace(b"FIELDS x y z\n", b"FIELDS x y z\nFIELDS x y z\n")
    yield "pcd of another encoding", data.replace(b"DATA binary", b"DATA zipped")
    yield "pcd with an endless header", b"# .PCD\n" + b"# a comment\n" * 10**5
    yield "pcd with an endless line", b"# .PCD " + b"a" * 10**6
    yield "pcd with a width of 5,000 digits", data.replace(b"WIDTH 60", b"WIDTH " + b"9" * 5000)
    yield "pcd of 30,000 fields", data.replace(b"FIELDS x", b"FIELDS " + b"x " * 30_000)
    size = POINTS.nbytes
    packed = lzf.compress(bytes(size))
    yield "lzf claiming 4 GB unpacked", pcd_packed(packed, len(packed), 2**32 - 1)
    yield "lzf claiming 4 GB packed", pcd_packed(packed, 2**32 - 1, size)
    yield "lzf claiming more than it reaches", pcd_packed(packed, len(packed), 24 * 10**6, 10**6)
    yield "lzf with other points than it holds", pcd_packed(packed, len(packed), size - 24)
    yield "lzf of fewer points than claimed", pcd_packed(packed, len(packed), size + 24, 61)
    yield "lzf that reaches before its start", pcd_packed(b"\xff" * 60, 60, size)
    yield "lzf that ends in a literal", pcd_packed(b"\x1f", 1, 24, 1)
    zeros_12 = lzf.compress(bytes(12 * 10**6))
    yield "lzf of a million zeros", pcd_packed(zeros_12, len(zeros_12), 24 * 10**6, 10**6)
    yield "lzf of no bytes", pcd_packed(b"", 0, size)
    yield (
        "lzf bomb",
        pcd_packed(
            lzf.compress(bytes(96 * 10**6)), len(lzf.compress(bytes(96 * 10**6))), 96 * 10**6, 4 * 10**6
        ),
    )


# LAS and LAZ ------------------------------------------------------------------------------------------------


def las_claiming(data: bytes, count: int) -> bytes:
    """Another number of points, in the field of 64 bits and none in that of 32."""
    return patch(patch(data, 107, "<L", 0), 247, "<Q", count)


def las_cases() -> Cases:
    old = {"las": las(version="1.2", format=1), "laz": laz(version="1.2", format=1)}
    new = {"las": las(), "laz": laz()}
    for kind, data in new.items():
        start = struct.unpack_from("<L", data, 96)[0]
        for name, count in {**COUNTS, "2^64-1": 2**64 - 1}.items():
            yield f"{kind} of {name} points", las_claiming(data, count)
        for name, count in BITS_32.items():
            if kind == "las" or count > 61:  # a chunk of that version does not say how many it holds
                yield f"{kind} 1.2 of {name} points", patch(old[kind], 107, "<L", count)
        yield f"{kind} of two counts", patch(data, 107, "<L", 7)
        yield f"{kind} of version 1.9", patch(data, 25, "<B", 9)
        yield f"{kind} with a header of no bytes", patch(data, 94, "<H", 0)
        yield f"{kind} with a header of 65,535 bytes", patch(data, 94, "<H", 65535)
        yield f"{kind} with points behind its end", patch(data, 96, "<L", 2**32 - 1)
        yield f"{kind} with points in its header", patch(data, 96, "<L", 100)
        yield f"{kind} with 2^32-1 records", patch(data, 100, "<L", 2**32 - 1)
        yield f"{kind} of format 63", patch(data, 104, "<B", 63 | (0x80 if kind == "laz" else 0))
        yield f"{kind} with points of 1 byte", patch(data, 105, "<H", 1)
        yield f"{kind} with points of 65,535 bytes", patch(data, 105, "<H", 65535)
        for name, value in {**NOT_FINITE, "0": 0.0}.items():
            yield f"{kind} with a scale of {name}", patch(data, 131, "<d", value)
        yield f"{kind} with an offset of nan", patch(data, 155, "<d", np.nan)
        yield f"{kind} with coordinates beyond all numbers", patch(data, 131, "<d", 1e308)
        yield f"{kind} with extended records in its header", patch(data, 235, "<QL", 3, 1)
        yield f"{kind} with extended records behind its end", patch(data, 235, "<QL", 2**63, 2**32 - 1)
        records = patch(data[:375] + bytes(2**25) + data[375:], 96, "<L", start + 2**25)
        yield f"{kind} with 32 MiB of records", records
        empty = patch(data[:375] + bytes(54 * 50_000) + data[375:], 96, "<L", start + 54 * 50_000)
        yield f"{kind} with 50,000 records", patch(empty, 100, "<L", 50_000)
        places = {
            "in the signature": 6,
            "in the header": 100,
            "behind the old header": 227,
            "in the counts": 250,
        }
        places |= {"at the points": start, "in the points": start + 50, "at the end": len(data) - 1}
        yield from cut(kind, data, places)
    extra = las(segment=np.arange(60, dtype="i4"))
    yield "las with a record that reaches into the points", patch(extra, 375 + 20, "<H", 65535)
    yield from laz_cases(old["laz"], new["laz"])


def laz_cases(old: bytes, new: bytes) -> Cases:
    yield "laz of 300,000 points in one place", laz(np.tile(POINTS[:1], (300_000, 1)))
    for name, data in (("laz 1.2", old), ("laz", new)):
        start = struct.unpack_from("<L", data, 96)[0]
        table = struct.unpack_from("<q", data, start)[0]
        record = data.index(b"laszip encoded") - 2 + 54
        for what, place in (
            ("behind the end", 2**62),
            ("in the header", 0),
            ("nowhere", -7),
            ("at the end", -1),
        ):
            yield f"{name} with chunks listed {what}", patch(data, start, "<q", place)
        for what, count in (("2^32-1", 2**32 - 1), ("10^6", 10**6), ("no", 0), ("2", 2)):
            yield f"{name} of {what} chunks", patch(data, table + 4, "<L", count)
        yield f"{name} with chunks of no points", patch(data, record + 12, "<L", 0)
        yield f"{name} with chunks of 7 points", patch(data, record + 12, "<L", 7)
        yield f"{name} not in chunks", patch(data, record, "<H", 1)
        yield f"{name} of 65,535 items", patch(data, record + 32, "<H", 65535)
        yield f"{name} with items of 65,535 bytes", patch(data, record + 34 + 2, "<H", 65535)
        yield f"{name} that does not say how", data.replace(b"laszip encoded", b"laszip unknown")
        yield from cut(name, data, {"at the table": table, "in the table": table + 6})
        many = 2 * 10**6
        claiming = patch(data, 107, "<L", many) if data is old else las_claiming(data, many)
        yield f"{name} of 2*10^6 points in one chunk", patch(claiming, record + 12, "<L", many)
        yield f"{name} of 2*10^6 points in a chunk of any size", patch(claiming, record + 12, "<L", 2**32 - 1)
    start = struct.unpack_from("<L", new, 96)[0]
    layers = start + 8 + 30 + 4
    for i in range(9):
        yield f"laz with layer {i} of 4 GB", patch(new, layers + 4 * i, "<L", 2**32 - 1)


# E57 --------------------------------------------------------------------------------------------------------


@cache
def _remainders() -> list[int]:
    values = list(range(256))
    for _ in range(8):
        values = [(value >> 1) ^ (0x82F63B78 if value & 1 else 0) for value in values]
    return values


def checksum(data: bytes) -> int:
    """CRC-32C, as each page of an E57 file ends with."""
    value, remainders = 0xFFFFFFFF, _remainders()
    for byte in data:
        value = remainders[(value ^ byte) & 0xFF] ^ (value >> 8)
    return value ^ 0xFFFFFFFF


def pages(plain: bytes) -> bytes:
    plain += bytes(-len(plain) % 1020)
    parts = [plain[i : i + 1020] for i in range(0, len(plain), 1020)]
    return b"".join(part + struct.pack(">L", checksum(part)) for part in parts)


def e57_with(data: bytes, old: bytes, new: bytes) -> bytes:
    """An E57 file with other XML and right checksums, sizes and places."""
    plain = b"".join(data[i : i + 1020] for i in range(0, len(data), 1024))
    start, length = struct.unpack_from("<2Q", plain, 24)
    start = start // 1024 * 1020 + start % 1024
    xml = plain[start : start + length]
    assert old in xml
    xml = xml.replace(old, new)
    n_bytes = -(-(start + len(xml)) // 1020) * 1024
    return pages(
        patch(plain[:start] + xml, 16, "<3Q", n_bytes, start // 1020 * 1024 + start % 1020, len(xml))
    )


def e57_repeated(data: bytes, times: int) -> bytes:
    """The same scan again and again, all of them at the same place in the file."""
    plain = b"".join(data[i : i + 1020] for i in range(0, len(data), 1024))
    scan = plain[plain.index(b"<vectorChild") : plain.index(b"</vectorChild>") + 14]
    return e57_with(data, scan, scan * times)


def e57_cases() -> Cases:
    data = e57(POINTS)
    for name, count in {**COUNTS, "-1": -1, "4*10^6": 4 * 10**6}.items():
        if count != 59:
            yield f"e57 of {name} points", e57_with(data, b'recordCount="60"', b'recordCount="%d"' % count)
    for name, count in (("2^64-1", 2**64 - 1), ("4 GB", 2**32), ("one page fewer", len(data) - 1024)):
        yield f"e57 claiming {name}", patch(data, 16, "<Q", count)
        yield f"e57 with XML behind {name}", patch(data, 24, "<Q", count)
        yield f"e57 with XML of {name}", patch(data, 32, "<Q", count)
    yield "e57 with XML of 1 MB", patch(data, 32, "<Q", 10**6)
    yield "e57 without XML", patch(data, 32, "<Q", 0)
    for size in (0, 1, 2**20, 2**63):
        yield f"e57 with pages of {size}", patch(data, 40, "<Q", size)
    yield "e57 of version 9", patch(data, 8, "<L", 9)
    yield "e57 with a wrong checksum", data[:100] + bytes([data[100] ^ 1]) + data[101:]
    root = b"<e57Root"
    entities = b"".join(b'<!ENTITY %c "%s">' % (b, b"&%c;" % (b - 1) * 10) for b in range(98, 108))
    yield (
        "e57 with entities",
        e57_with(data, root, b'<!DOCTYPE a [<!ENTITY a "ha">' + entities + b"]>" + root),
    )
    yield (
        "e57 with a file as entity",
        e57_with(data, root, b'<!DOCTYPE a [<!ENTITY a SYSTEM "file:///etc/hostname">]>' + root),
    )
    deep = b'<a type="Structure">' * 10**4 + b"</a>" * 10**4
    yield "e57 nested 10,000 deep", e57_with(data, b"<data3D", deep + b"<data3D")
    wide = b"".join(b'<a%d type="Integer"/>' % i for i in range(30_000))
    yield "e57 with 30,000 elements", e57_with(data, b"<data3D", wide + b"<data3D")
    yield "e57 with 30,000 fields", e57_with(data, b"<cartesianX", wide + b"<cartesianX")
    yield "e57 with 900 scans of the same bytes", e57_repeated(e57(spoilt(np.nan)), 900)
    yield "e57 with broken XML", e57_with(data, b"</e57Root>", b"")
    yield "e57 in UTF-7", e57_with(data, b'encoding="UTF-8"', b'encoding="UTF-7"')
    yield "e57 without scans", e57()
    yield "e57 without data", e57_with(data, b"data3D", b"data4D")
    yield "e57 without coordinates", e57_with(data, b"cartesianX", b"cartesianW")
    for name, place in (("behind the end", 2**40), ("in the XML", len(data) - 1024), ("in the header", 8)):
        yield f"e57 with points {name}", e57_with(data, b'fileOffset="48"', b'fileOffset="%d"' % place)
    yield (
        "e57 with coordinates of no bits",
        e57_with(
            e57_with(data, b'recordCount="60"', b'recordCount="4000000"'),
            b'type="Float"',
            b'type="Integer" minimum="0" maximum="0"',
        ),
    )
    places = {"in the header": 30, "behind the header": 48, "in a page": 1000, "at a page": 1024}
    yield from cut("e57", data, {**places, "before the XML": len(data) - 2048, "at the end": len(data) - 1})
    for name, value in NOT_FINITE.items():
        yield f"e57 with {name}", e57(spoilt(value))


CASES = dict(
    case for cases in (npy_cases, npz_cases, ply_cases, pcd_cases, las_cases, e57_cases) for case in cases()
)
