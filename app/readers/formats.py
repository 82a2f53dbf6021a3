"""The formats that are read, as they are told to clients; files are recognized by what they hold."""

from dataclasses import dataclass

from primfit.fitting.names import Unit


@dataclass(frozen=True)
class Format:
    """A format that clouds are read from.

    Attributes
    ----------
    name : as `receipt.format` has it
    how : what is read of it
    extensions, media_types : how its files are labeled
    unit : of its coordinates, where the format has one; the others may hold any
    """

    name: str
    how: str
    extensions: tuple[str, ...]
    media_types: tuple[str, ...]
    unit: Unit | None = None


FORMATS = (
    Format(
        "text",
        "one point a line, separated by comma, semicolon, tab or white space; an optional header",
        (".csv", ".xyz", ".txt", ".pts", ".asc"),
        ("text/csv", "text/plain", "text/tab-separated-values"),
    ),
    Format(
        "npy", "an array (N, 3) or wider, or records with fields x, y, z", (".npy",), ("application/x-npy",)
    ),
    Format(
        "npz",
        "the array points or xyz, with normals and labels beside it",
        (".npz",),
        ("application/x-npz",),
    ),
    Format("ply", "x, y, z of the vertices, ascii or binary", (".ply",), ("model/ply", "application/ply")),
    Format("pcd", "fields x, y, z, ascii, binary or binary_compressed", (".pcd",), ()),
    Format(
        "ptx", "the points of all scans, moved by their poses; rows of 0 0 0 are missing", (".ptx",), (), "m"
    ),
    Format("las", "scaled coordinates of all returns", (".las",), ("application/vnd.las",), "m"),
    Format("laz", "scaled coordinates of all returns", (".laz",), ("application/vnd.laszip",), "m"),
    Format("e57", "the valid points of all scans; needs the extra e57", (".e57",), ("model/e57",), "m"),
    Format("stl", "the distinct vertices, ascii or binary", (".stl",), ("model/stl",)),
    Format("obj", "the distinct vertices", (".obj",), ("model/obj",)),
    Format("glb", "the distinct vertices of the default scene", (".glb",), ("model/gltf-binary",), "m"),
    Format("json", "an object with points, as rows or as a base64 array", (".json",), ("application/json",)),
)
UNIT_OF = {format.name: format.unit for format in FORMATS}
NAMES = ", ".join(extension[1:].upper() for format in FORMATS for extension in format.extensions)
# Answers are JSON: in a folder none is taken for a cloud.
SUFFIXES = tuple(
    sorted(extension for format in FORMATS if format.name != "json" for extension in format.extensions)
)
PACKED = (".gz", ".zst")
