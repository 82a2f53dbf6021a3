"""The instances of a STEP file (ISO 10303-21)."""

from importlib.metadata import version

import numpy as np

from primfit.fitting.geometry.vectors import Array

SCHEMA = "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }"
EPOCH = "1970-01-01T00:00:00"


class File:
    """The instances of a file, numbered as they come; what an instance refers to is added before it."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def add(self, instance: str) -> str:
        self.lines.append(f"#{len(self.lines) + 1}={instance};")
        return f"#{len(self.lines)}"

    def point(self, at: Array) -> str:
        return self.add(f"CARTESIAN_POINT('',({','.join(map(real, at))}))")

    def direction(self, along: Array) -> str:
        return self.add(f"DIRECTION('',({','.join(map(real, along))}))")

    def placement(self, at: Array, axis: Array, reference: Array) -> str:
        references = self.point(at), self.direction(axis), self.direction(reference)
        return self.add(f"AXIS2_PLACEMENT_3D('',{','.join(references)})")

    def vertex(self, at: Array) -> str:
        return self.add(f"VERTEX_POINT('',{self.point(at)})")

    def line(self, start: Array, end: Array) -> str:
        along = end - start
        length = float(np.sqrt(along @ along))
        vector = self.add(f"VECTOR('',{self.direction(along / length)},1.)")
        return self.add(f"LINE('',{self.point(start)},{vector})")

    def circle(self, center: Array, axis: Array, reference: Array, radius: float) -> str:
        return self.add(f"CIRCLE('',{self.placement(center, axis, reference)},{real(radius)})")

    def edge(self, start: str, end: str, curve: str) -> str:
        return self.add(f"EDGE_CURVE('',{start},{end},{curve},.T.)")

    def text(self, name: str) -> str:
        """The whole file, about a product of this name."""
        header = [
            "ISO-10303-21;",
            "HEADER;",
            "FILE_DESCRIPTION(('a primitive recognized in a point cloud'),'2;1');",
            f"FILE_NAME({quoted(name)},'{EPOCH}',(''),(''),'primfit {version('primfit')}','primfit','');",
            f"FILE_SCHEMA(('{SCHEMA}'));",
            "ENDSEC;",
            "DATA;",
        ]
        return "\n".join([*header, *self.lines, "ENDSEC;", "END-ISO-10303-21;", ""])


def quoted(text: str) -> str:
    """A text as Part 21 wants it: in quotes, ASCII alone, other characters by their numbers."""
    doubled = text.replace("\\", "\\\\").replace("'", "''")
    return f"'{''.join(map(_letter, doubled))}'"


def _letter(letter: str) -> str:
    if " " <= letter <= "~":
        return letter
    number = ord(letter)
    return f"\\X4\\{number:08X}\\X0\\" if number > 0xFFFF else f"\\X2\\{number:04X}\\X0\\"


def real(value: float) -> str:
    """A number as Part 21 wants it: a point always, a capital E."""
    mantissa, _, exponent = repr(float(value)).partition("e")
    mantissa = mantissa.removesuffix("0") if mantissa.endswith(".0") else mantissa
    point = "" if "." in mantissa else "."
    return f"{mantissa}{point}E{exponent}" if exponent else f"{mantissa}{point}"
