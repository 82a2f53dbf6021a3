"""Scans that are read piece by piece give what the readers of whole files give."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest
from plyfile import PlyData, PlyElement

from primfit.app.readers import Cloud, Pick, UnreadableFileError, read
from primfit.app.readers.las import las_pieces
from primfit.app.readers.ply import ply_pieces

RNG = np.random.default_rng(3)
N = 1000
PICK = Pick("auto")


def las_file(path: Path, point_format: int, labels: np.ndarray) -> Path:
    header = laspy.LasHeader(point_format=point_format, version="1.4")
    header.scales, header.offsets = np.full(3, 1e-3), np.array([4e5, 5e6, 100.0])
    header.add_extra_dim(laspy.ExtraBytesParams("segment_id", labels.dtype))
    las = laspy.LasData(header)
    las.x, las.y, las.z = RNG.random((3, len(labels))) * 50 + header.offsets[:, None]
    las.segment_id = labels
    las.write(str(path))
    return path


def ply_file(path: Path, order: str, before: bool = False, normals: bool = False) -> Path:
    names = ["x", "y", "z", *(["nx", "ny", "nz"] if normals else [])]
    rows = np.zeros(N, [*((name, "f4") for name in names), ("red", "u1"), ("label", "i4")])
    for name in names:
        rows[name] = RNG.normal(size=N)
    rows["label"] = RNG.integers(-5, 5, N)
    cameras = np.zeros(3, [("focus", "f8"), ("id", "u1")])
    elements = [PlyElement.describe(cameras, "camera")] if before else []
    faces = np.array([([0, 1, 2],)], [("vertex_indices", "i4", (3,))])
    elements += [PlyElement.describe(rows, "vertex"), PlyElement.describe(faces, "face")]
    PlyData(elements, text=order == "=", byte_order=order).write(str(path))
    return path


def joined(pieces: list[Cloud], name: str) -> bytes:
    return b"".join(getattr(piece, name).tobytes() for piece in pieces)


def check_same(pieces: list[Cloud], whole: Cloud, n_points: int) -> None:
    assert [len(piece.points) for piece in pieces[:-1]] == [n_points] * (len(pieces) - 1)
    for name in ("points", "labels", "normals"):
        if getattr(whole, name) is not None:
            assert joined(pieces, name) == getattr(whole, name).tobytes()
    for piece in pieces:
        told = [
            (c.columns, c.format, c.label_column, c.unit, c.unit_from, c.warnings) for c in (piece, whole)
        ]
        assert told[0] == told[1]
        assert piece.labels is not None and whole.labels is not None
        assert piece.labels.dtype == whole.labels.dtype


@pytest.mark.parametrize("suffix", [".las", ".laz"])
@pytest.mark.parametrize("point_format", [3, 7])
@pytest.mark.parametrize("n_points", [130, 1000, 5000])
def test_las(suffix: str, point_format: int, n_points: int, tmp_path: Path) -> None:
    path = las_file(tmp_path / f"scan{suffix}", point_format, RNG.integers(0, 9, N).astype(np.int32))
    with path.open("rb") as file:
        pieces = list(las_pieces(file, PICK, n_points))
    check_same(pieces, read(path.read_bytes(), pick=PICK), n_points)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("before", [False, True])
@pytest.mark.parametrize("normals", [False, True])
def test_ply(order: str, before: bool, normals: bool, tmp_path: Path) -> None:
    path = ply_file(tmp_path / "scan.ply", order, before, normals)
    with path.open("rb") as file:
        pieces = ply_pieces(file, PICK, 130)
        assert pieces is not None
        found = list(pieces)
    assert (found[0].normals is not None) == normals
    check_same(found, read(path.read_bytes(), pick=PICK), 130)


def test_an_ascii_ply_is_none_for_pieces(tmp_path: Path) -> None:
    with ply_file(tmp_path / "scan.ply", "=").open("rb") as file:
        assert ply_pieces(file, PICK, 130) is None


def refused(data: bytes, path: Path) -> tuple[Any, Any]:
    """What both ways of reading say against some bytes."""
    path.write_bytes(data)
    with pytest.raises(UnreadableFileError) as whole:
        read(data, pick=PICK)
    with pytest.raises(UnreadableFileError) as in_pieces, path.open("rb") as file:
        pieces: Iterator[Cloud] | None = las_pieces(file, PICK, 130) if data[:1] == b"L" else None
        for _ in ply_pieces(file, PICK, 130) or () if pieces is None else pieces:
            pass
    return (whole.value.field, whole.value.message), (in_pieces.value.field, in_pieces.value.message)


@pytest.mark.parametrize("n_left", [50, 300, 2000, -400])
@pytest.mark.parametrize("name", ["scan.las", "scan.laz", "scan.ply"])
def test_files_that_are_cut_off_are_refused_alike(name: str, n_left: int, tmp_path: Path) -> None:
    path = tmp_path / name
    if name.endswith("ply"):
        ply_file(path, "<")
    else:
        las_file(path, 3, RNG.integers(0, 9, N).astype(np.int32))
    whole, in_pieces = refused(path.read_bytes()[:n_left], path)
    assert in_pieces == whole


@pytest.mark.parametrize("place", [4, 25, 96, 100, 104, 105, 107, 131])
def test_headers_that_lie_are_refused_alike(place: int, tmp_path: Path) -> None:
    path = las_file(tmp_path / "scan.laz", 3, RNG.integers(0, 9, N).astype(np.int32))
    data = bytearray(path.read_bytes())
    data[place] ^= 0xFF
    try:
        read(bytes(data), pick=PICK)
    except UnreadableFileError:
        whole, in_pieces = refused(bytes(data), path)
        assert in_pieces == whole
    else:
        with path.open("rb") as file:
            assert sum(len(piece.points) for piece in las_pieces(file, PICK, 130)) == N


def test_a_label_that_is_no_whole_number_is_told_by_its_number_in_the_file(tmp_path: Path) -> None:
    labels = RNG.integers(0, 9, N).astype(np.float64)
    labels[777] = 0.5
    path = las_file(tmp_path / "scan.las", 3, labels)
    whole, in_pieces = refused(path.read_bytes(), path)
    assert in_pieces == whole
    assert whole[0] == "labels[777]"
