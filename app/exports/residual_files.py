"""The residuals of all points, in the order and the unit of the input, as NPY, CSV, PLY and LAS."""

import csv
import logging
from datetime import date
from importlib.metadata import version
from io import BytesIO, StringIO

import numpy as np

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.names import Unit

from ..readers.units import METERS
from .colors import color_limit, diverging
from .fitted import Fitted
from .options import ExportOptions
from .ply import Element, ply

EPOCH = date(1970, 1, 1)
LAS_STEPS = 2**31 - 1
"""A coordinate in a LAS file is a whole number of steps of at most this size."""


def residuals_npy(fitted: Fitted, options: ExportOptions) -> bytes:
    """The signed residuals, float64 (N,)."""
    stream = BytesIO()
    np.save(stream, fitted.residuals.distance, allow_pickle=False)
    return stream.getvalue()


def residuals_csv(fitted: Fitted, options: ExportOptions) -> bytes:
    """`x,y,z,residual,inlier`, floats in the fewest digits that read back to the same value."""
    residuals = fitted.residuals
    columns = (*fitted.points.T, residuals.distance, residuals.inlier.astype(int))
    stream = StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(("x", "y", "z", "residual", "inlier"))
    writer.writerows(zip(*(column.tolist() for column in columns), strict=True))
    return stream.getvalue().encode()


def residuals_ply(fitted: Fitted, options: ExportOptions) -> bytes:
    """Binary PLY: coordinates and residuals in float64, and the residuals as colors."""
    points, residuals = fitted.points, fitted.residuals
    limit = color_limit(residuals)
    properties = [
        *(("double", name, "<f8") for name in ("x", "y", "z", "residual")),
        *(("uchar", name, "u1") for name in ("inlier", "red", "green", "blue")),
    ]
    columns = (*points.T, residuals.distance, residuals.inlier, *diverging(residuals.distance, limit).T)
    table = np.empty(len(points), [(name, dtype) for _, name, dtype in properties])
    for (_, name, _), column in zip(properties, columns, strict=True):
        table[name] = column
    about = f"residuals of a {fitted.primitive.kind}, from blue at {-limit!r} to red at {limit!r}"
    return ply(about, Element("vertex", [f"{type_name} {name}" for type_name, name, _ in properties], table))


def residuals_las(fitted: Fitted, options: ExportOptions) -> bytes:
    """LAS 1.4 with the extra dimensions `residual` and `inlier`; coordinates are rounded to its steps."""
    import laspy

    logging.getLogger("laspy").setLevel(logging.CRITICAL)
    points, residuals = fitted.points, fitted.residuals
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.creation_date = EPOCH
    header.generating_software = f"primfit {version('primfit')}"
    header.add_extra_dims(
        [
            laspy.ExtraBytesParams("residual", "float64", "signed distance, outside +"),
            laspy.ExtraBytesParams("inlier", "uint8", "1: not rejected"),
        ]
    )
    if options.unit is not None:
        header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr(_local_system(options.unit)))
        header.global_encoding.wkt = True
    step, header.offsets = las_grid(points)
    header.scales = np.full(3, step)
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = points.T
    cloud["residual"], cloud["inlier"] = residuals.distance, residuals.inlier
    stream = BytesIO()
    cloud.write(stream)
    return stream.getvalue()


def _local_system(unit: Unit) -> str:
    """Well-known text (OGC 01-009) of a coordinate system that says its unit only; LAS is in meters else."""
    length = f'UNIT["{unit}",{METERS[unit]!r}]'
    return f'LOCAL_CS["primfit",LOCAL_DATUM["unknown",0],{length},AXIS["X",OTHER],AXIS["Y",OTHER]]'


def las_grid(points: Array) -> tuple[float, Array]:
    """The step and the offsets (3,) of the coordinates: the finest power of ten that all points fit into.

    Offsets are whole numbers of steps near the middle, so that decimal coordinates stay on the grid.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    reach = float(np.max(high / 2.0 - low / 2.0))
    step = float(10.0 ** np.ceil(np.log10(reach / (0.9 * LAS_STEPS))))
    coarse = step * 1e8
    return step, np.round((low / 2.0 + high / 2.0) / coarse) * coarse + 0.0
