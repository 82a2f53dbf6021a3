"""OBJ: its vertices; what `mtllib` and the like name is never opened.

Own reader, not a library's: trimesh takes a second and 60 MB to import, for lines that start with `v`.
"""

import re
from collections.abc import Iterator

from .cloud import Cloud
from .columns import FOUND, Pick, canonical
from .limits import UNLIMITED, Limits
from .lines import check_lines, decoded, lines, load_triples, plain_numbers
from .mesh import build_mesh

_HEAD = 1024 * 1024
_KEYWORDS = {"v", "vn", "vt", "vp", "f", "l", "p", "o", "g", "s", "mtllib", "usemtl"}
# A line that holds more than white space and a comment.
_TOLD = re.compile(r"^[^\S\n]*+[^\s#].*", re.MULTILINE)
_NUMBER = rb"[ \t]+[-+]?\.?\d[^\s]*"
_VERTEX = re.compile(rb"^[ \t]*v" + 3 * _NUMBER, re.MULTILINE)


def is_obj(data: memoryview) -> bool:
    """Whether the first line that says something is one of an OBJ file, and a line of the first MiB a vertex.

    No table passes: its rows start with numbers, and a header names the coordinates.
    """
    told = _TOLD.search(decoded(bytes(data[:_HEAD])))
    words = told[0].partition("#")[0].split() if told else []
    if not words or words[0] not in _KEYWORDS or {"x", "y", "z"} <= {canonical(word) for word in words}:
        return False
    return _VERTEX.search(data[:_HEAD]) is not None


def read_obj(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read the distinct vertices, and their normals where each vertex has one of its own."""
    check_lines(data)
    text = plain_numbers(bytes(data))

    def rows(keyword: str) -> Iterator[tuple[int, str]]:
        for number, line in lines(text, re.compile(rf"^[^\S\n]*+{keyword}[ \t]", re.MULTILINE)):
            if line.lstrip().startswith((f"{keyword} ", f"{keyword}\t")):
                yield number, line

    vertices = load_triples(lambda: rows("v"), "vertex")
    normals = load_triples(lambda: rows("vn"), "normal")
    paired = len(normals) == len(vertices) and all(_is_paired(line) for _, line in rows("f"))
    return build_mesh(vertices, normals if paired else None, "obj", limits, pick)


def _is_paired(face: str) -> bool:
    """Whether each corner of a face (`v`, `v/vt`, `v//vn`, `v/vt/vn`) has the normal of its own vertex."""
    for corner in face.split()[1:]:
        vertex, *_, normal = corner.split("/") if corner.count("/") == 2 else (corner, corner)
        if vertex != normal:
            return False
    return True
