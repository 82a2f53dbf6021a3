"""A row a segment: the columns of the Parquet files of a run, and what each of them is taken from.

Every file is GeoParquet 1.1: `geometry` is the center of the box that the points of the segment fill. Nothing
in it depends on when, where or by how many processes it was made.
"""

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
import orjson

from primfit.fitting.answer.result import Recognition
from primfit.fitting.answer.values import ErrorSummary, NoiseSummary
from primfit.fitting.names import KINDS
from primfit.fitting.primitives import DIRECTIONS, names_of

from ..engine.answer import to_json
from .arrow import arrow
from .refs import Ref

if TYPE_CHECKING:
    import pyarrow as pa

Row = dict[str, Any]
"""Cells by the names of their columns; what is missing is null."""

VERSION = 1
"""Of the columns: a new one, or another meaning of one, makes a new version."""

PROBLEM = "problem"
"""The status of a segment that could not be fitted; the others are those of an answer."""

PARAMETERS = tuple(dict.fromkeys(name for kind in KINDS for name in names_of(kind)))
BOUNDED = tuple(name for name in PARAMETERS if name.split(".")[0] not in DIRECTIONS)
"""Numbers of all kinds, `axis.x` and `radius`, and those of them that have an interval of their own."""

_ERRORS = tuple(field.name for field in fields(ErrorSummary))
_DEVIATIONS = ("correlated", "smooth")
_NOISE = tuple(field.name for field in fields(NoiseSummary) if field.name not in _DEVIATIONS)
_ENDS = ("low", "high", "standard_deviation")
_WORDS = ("status", "kind", "unit", "noise_model", "conformance")
"""Columns of few words, of which each is stored once a file."""

BOX = ("xmin", "ymin", "zmin", "xmax", "ymax", "zmax")
COVERING = ("xmin", "ymin", "xmax", "ymax")
"""Sides of a box, and those of them that GeoParquet 1.1 names."""

_POINT_Z = struct.Struct("<BI3d")
_WKB_POINT_Z = 1001


def answered_row(ref: Ref, found: Recognition, answer: Mapping[str, Any]) -> Row:
    """The row of a segment that was answered.

    Parameters
    ----------
    found, answer : what `engine.answer.answered` gave
    """
    receipt = answer["receipt"]
    box = _box(found)
    return {
        **_where(ref),
        "n_points": receipt["n_points"],
        "status": answer["status"],
        "kind": answer["primitive"] and answer["primitive"]["kind"],
        "message": answer["message"],
        "alternatives": [other["kind"] for other in answer["alternatives"]],
        "warnings": list(answer["warnings"]),
        **_flat(answer["primitive"] or {}),
        "unit": receipt["unit"],
        **(answer["error"] or {}),
        **_noise(answer["noise"] or {}),
        **_known(answer["uncertainty"] or {}),
        **_sized(answer["extents"] or {}),
        **_evidence(answer["attempts"]),
        "conformance": answer["conformance"] and answer["conformance"]["verdict"],
        "input_sha256": receipt["input_sha256"],
        "receipt": to_json(receipt).decode(),
        "answer": to_json(answer).decode(),
        "bbox": box and dict(zip(BOX, box, strict=True)),
        "geometry": box and _center(box),
    }


def problem_row(ref: Ref, message: str) -> Row:
    """The row of a segment that could not be fitted, and why."""
    return {**_where(ref), "status": PROBLEM, "message": message}


@cache
def schema() -> "pa.Schema":
    """The columns; raises `ImportError` where pyarrow is missing."""
    pa = arrow()
    return pa.schema(
        [pa.field(name, of, nullable=name not in ("id", "file", "status")) for name, of in _columns(pa)]
    )


def written(rows: Sequence[Row], about: Mapping[str, Any]) -> bytes:
    """Rows as a Parquet file; the same rows give the same bytes, with one version of pyarrow.

    Parameters
    ----------
    about : more of the file, in plain values, which stands in its metadata beside the version of the columns

    Raises `ImportError` where pyarrow is missing.
    """
    pa, stream = arrow(), BytesIO()
    table = pa.Table.from_pylist(list(rows), schema=schema())
    said = {"primfit": said_of(about), "geo": geo_of(_whole(rows))}
    import pyarrow.parquet as parquet

    parquet.write_table(
        table.replace_schema_metadata(said), stream, compression="zstd", use_dictionary=list(_WORDS)
    )
    return stream.getvalue()


def said_of(about: Mapping[str, Any]) -> bytes:
    """What a file says of itself in its metadata, under `primfit`."""
    return orjson.dumps({"schema": "primfit.answers", "version": VERSION, **about})


def geo_of(box: Sequence[float] | None) -> bytes:
    """What GeoParquet 1.1 wants in the metadata under `geo`; `box` is that of all geometries, if known.

    No `crs` is told: the coordinates are those of the clouds, whatever they are in.
    """
    column: dict[str, Any] = {
        "encoding": "WKB",
        "geometry_types": ["Point Z"],
        "crs": None,
        "covering": {"bbox": {side: ["bbox", side] for side in COVERING}},
    }
    if box is not None:
        column["bbox"] = list(box)
    return orjson.dumps({"version": "1.1.0", "primary_column": "geometry", "columns": {"geometry": column}})


@dataclass(frozen=True)
class Told:
    """What a file says of itself, and the status of each of its rows."""

    about: Mapping[str, Any]
    statuses: Sequence[str]


def told_of(content: bytes) -> Told | None:
    """What the bytes of a file say; None where they are none that `written` has made."""
    pa = arrow()
    import pyarrow.parquet as parquet

    try:
        file = parquet.ParquetFile(BytesIO(content))
        about = orjson.loads((file.schema_arrow.metadata or {})[b"primfit"])
        return Told(about, file.read(["status"]).column("status").to_pylist())
    except (pa.ArrowException, OSError, KeyError, ValueError):
        return None


def _columns(pa: Any) -> Iterator[tuple[str, Any]]:
    """Names and types, in their order."""
    number, text = pa.float64(), pa.string()
    words = dict.fromkeys(_WORDS, pa.dictionary(pa.int8(), text))
    lists = dict.fromkeys(("alternatives", "warnings"), pa.list_(text))
    yield from dict.fromkeys(("id", "file", "label"), text).items()
    yield "n_points", pa.int64()
    for name in ("status", "kind", "message", "alternatives", "warnings"):
        yield name, words.get(name) or lists.get(name, text)
    yield from dict.fromkeys(map(_column, PARAMETERS), number).items()
    yield "unit", words["unit"]
    yield from dict.fromkeys((*_ERRORS, *(f"noise_{name}" for name in _NOISE)), number).items()
    for name in _DEVIATIONS:
        yield from dict.fromkeys((f"noise_{name}_size", f"noise_{name}_range"), number).items()
    yield "noise_model", words["noise_model"]
    yield from ((f"{_column(name)}_{end}", number) for name in BOUNDED for end in _ENDS)
    yield from dict.fromkeys(
        ("direction_radius_95", "position_radius_95", "area", "coverage"), number
    ).items()
    yield from ((f"{of}_{kind}", number) for of in ("probability", "evidence") for kind in KINDS)
    yield "conformance", words["conformance"]
    yield from dict.fromkeys(("input_sha256", "receipt", "answer"), text).items()
    yield "bbox", pa.struct([(side, number) for side in BOX])
    yield "geometry", pa.binary()


def _column(name: str) -> str:
    return name.replace(".", "_")


def _where(ref: Ref) -> Row:
    return {"id": ref.id, "file": ref.file, "label": None if ref.label is None else str(ref.label)}


def _flat(primitive: Mapping[str, Any]) -> Row:
    """Its parameters, vectors as three columns."""
    row: Row = {}
    for name, value in primitive.items():
        if isinstance(value, list):
            row |= {f"{name}_{along}": number for along, number in zip("xyz", value, strict=True)}
        elif name != "kind":
            row[name] = value
    return row


def _noise(noise: Mapping[str, Any]) -> Row:
    row: Row = {f"noise_{name}": noise.get(name) for name in _NOISE}
    for name in _DEVIATIONS:
        found = noise.get(name) or {}
        row |= {f"noise_{name}_size": found.get("size"), f"noise_{name}_range": found.get("range")}
    return row


def _known(uncertainty: Mapping[str, Any]) -> Row:
    """How well its numbers are known."""
    row: Row = {"noise_model": uncertainty.get("noise_model")}
    for name, interval in uncertainty.get("intervals", {}).items():
        row |= {f"{_column(name)}_{end}": interval[end] for end in _ENDS}
    for name in ("direction", "position"):
        row[f"{name}_radius_95"] = (uncertainty.get(name) or {}).get("radius_95")
    return row


def _sized(extents: Mapping[str, Any]) -> Row:
    return {name: extents.get(name) for name in ("area", "coverage")}


def _evidence(attempts: Sequence[Mapping[str, Any]]) -> Row:
    return {f"{of}_{each['kind']}": each[of] for each in attempts for of in ("probability", "evidence")}


def _box(found: Recognition) -> tuple[float, ...] | None:
    """Of the points that belong to the primitive, of all of them where nothing fits."""
    points = found.kept_points()
    if found.status != "no_fit" and found.inliers.any():
        points = points[found.inliers]
    points = points[np.isfinite(points).all(axis=1)]
    return (*points.min(axis=0).tolist(), *points.max(axis=0).tolist()) if len(points) else None


def _center(box: Sequence[float]) -> bytes:
    """The center of a box as well-known binary."""
    return _POINT_Z.pack(1, _WKB_POINT_Z, *_middle(box))


def _middle(box: Sequence[float]) -> list[float]:
    return [low + (high - low) / 2.0 for low, high in zip(box[:3], box[3:], strict=True)]


def _whole(rows: Sequence[Row]) -> list[float] | None:
    """The box of the geometries of some rows."""
    centers = [_middle(list(row["bbox"].values())) for row in rows if row.get("bbox")]
    if not centers:
        return None
    return [*np.min(centers, axis=0).tolist(), *np.max(centers, axis=0).tolist()]
