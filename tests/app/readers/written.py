"""Clouds as files, each written by a library that the reader under test does not use for reading."""

import io
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import laspy
import numpy as np
import plyfile
import pye57
from numpy.typing import NDArray
from pye57 import libe57
from pypcd4 import Encoding, PointCloud

Array = NDArray[np.float64]
Extra = dict[str, NDArray[Any]]

STEP = 1e-4
GRID = np.random.default_rng(3).integers(-(10**6), 10**6, (60, 3))
"""Whole numbers of steps, beside offsets far from the origin: coordinates of a georeferenced scan."""
OFFSET = np.array([1e6, -2e6, 3.0])
POINTS = GRID * STEP + OFFSET


def npy(array: NDArray[Any], allow_pickle: bool = False) -> bytes:
    """NPY, by NumPy."""
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=allow_pickle)
    return stream.getvalue()


def npz(compressed: bool = True, **arrays: NDArray[Any]) -> bytes:
    """NPZ, by NumPy."""
    stream = io.BytesIO()
    (np.savez_compressed if compressed else np.savez)(stream, **arrays)
    return stream.getvalue()


def records(points: Array, kind: str = "f8", **extra: NDArray[Any]) -> NDArray[Any]:
    """Points and what stands beside them as a structured array (N,)."""
    table = np.empty(
        len(points), [(name, kind) for name in "xyz"] + [(name, extra[name].dtype) for name in extra]
    )
    for name, values in zip("xyz", points.T, strict=True):
        table[name] = values
    for name, values in extra.items():
        table[name] = values
    return table


def ply(*elements: tuple[NDArray[Any], str], text: bool = False, order: str = "<") -> bytes:
    """PLY, by plyfile."""
    described = [plyfile.PlyElement.describe(table, name) for table, name in elements]
    stream = io.BytesIO()
    plyfile.PlyData(described, text=text, byte_order="=" if text else order).write(stream)
    return stream.getvalue()


def pcd(points: Array, encoding: str = "binary", kind: str = "f8", **extra: NDArray[Any]) -> bytes:
    """PCD, by pypcd4."""
    columns = [*points.T, *extra.values()]
    kinds = [np.dtype(kind)] * 3 + [values.dtype for values in extra.values()]
    cloud = PointCloud.from_points(columns, ("x", "y", "z", *extra), kinds)
    with TemporaryDirectory() as folder:
        path = Path(folder, "cloud.pcd")
        cloud.save(path, Encoding(encoding))
        return path.read_bytes()


def las(
    points: Array = POINTS,
    compressed: bool = False,
    version: str = "1.4",
    format: int = 6,
    **extra: NDArray[Any],
) -> bytes:
    """LAS or LAZ in steps of 1e-4, by laspy; `extra` become extra dimensions, or fill those of their name."""
    header = laspy.LasHeader(version=version, point_format=format)
    header.scales, header.offsets = np.full(3, STEP), OFFSET
    known = set(header.point_format.dimension_names)
    for name in extra.keys() - known:
        header.add_extra_dim(laspy.ExtraBytesParams(name, extra[name].dtype))
    data = laspy.LasData(header)
    data.x, data.y, data.z = points.T
    for name, values in extra.items():
        data[name] = values
    stream = io.BytesIO()
    data.write(stream, do_compress=compressed)
    return stream.getvalue()


def laz(points: Array = POINTS, **options: Any) -> bytes:
    """LAZ, by laspy and lazrs."""
    return las(points, compressed=True, **options)


CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")


def e57(
    *scans: Array,
    kind: str = "double",
    pose: Sequence[float] | None = None,
    systems: Sequence[Sequence[str]] = (),
    **extra: NDArray[Any],
) -> bytes:
    """E57, by libE57Format: coordinates as `double`, `single` or `scaled` integers in steps of 1e-4.

    `pose` is a quaternion w, x, y, z and a shift; `systems` names the coordinates of each scan, which are
    cartesian if it does not; `extra` are integer fields of each scan.
    """
    with TemporaryDirectory() as folder:
        path = Path(folder, "cloud.e57")
        with pye57.E57(str(path), "w") as file:
            for points, system in zip(scans, systems or [CARTESIAN] * len(scans), strict=True):
                _write_scan(file, dict(zip(system, points.T, strict=True)), kind, pose, extra)
        return path.read_bytes()


def _write_scan(
    file: pye57.E57, points: Extra, kind: str, pose: Sequence[float] | None, extra: Extra
) -> None:
    image = file.image_file
    scan = libe57.StructureNode(image)
    if pose is not None:
        parts = libe57.StructureNode(image)
        scan.set("pose", parts)
        for part, names, values in (("rotation", "wxyz", pose[:4]), ("translation", "xyz", pose[4:])):
            node = libe57.StructureNode(image)
            parts.set(part, node)
            for name, value in zip(names, values, strict=True):
                node.set(name, libe57.FloatNode(image, value))
    prototype = libe57.StructureNode(image)
    buffers = libe57.VectorSourceDestBuffer()
    kept = []
    for name, values in (points | extra).items():
        prototype.set(name, _field(image, kind, name in extra))
        kept.append(np.ascontiguousarray(values, dtype=np.float64))
        buffers.append(libe57.SourceDestBuffer(image, name, kept[-1], len(values), True, True))
    records = libe57.CompressedVectorNode(image, prototype, libe57.VectorNode(image, True))
    scan.set("points", records)
    file.data3d.append(scan)
    writer = records.writer(buffers)
    writer.write(len(kept[0]))
    writer.close()


def _field(image: Any, kind: str, integer: bool) -> Any:
    if integer:
        return libe57.IntegerNode(image, 0, 0, 2**20)
    if kind == "scaled":
        return libe57.ScaledIntegerNode(image, 0, -(2**62), 2**62, STEP, 0.0)
    precision = libe57.E57_DOUBLE if kind == "double" else libe57.E57_SINGLE
    return libe57.FloatNode(image, 0.0, precision)
