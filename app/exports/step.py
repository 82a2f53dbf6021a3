"""STEP (ISO 10303-21, AP214): the trimmed primitive as a shell of one face on its exact surface.

The same answer gives the same bytes: the time stamp is that of the epoch.
"""

from importlib.metadata import version

import numpy as np

from primfit.fitting.extents.values import Extents
from primfit.fitting.geometry.vectors import Array, basis, cross
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

from .fitted import Fitted
from .options import ExportOptions
from .patch import NothingToExportError, Patch, Pieces, patch_of, trimmed

SCHEMA = "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }"
EPOCH = "1970-01-01T00:00:00"

UNCERTAINTY = 1e-7
"""Points closer than this share of the size are one: what readers join edges by."""

Edge = tuple[str, bool]
"""Reference to an edge, and whether it is run through in its own direction."""


class _File:
    """The instances of a file, numbered as they come."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def add(self, instance: str) -> str:
        self.lines.append(f"#{len(self.lines) + 1}={instance};")
        return f"#{len(self.lines)}"

    def point(self, at: Array) -> str:
        return self.add(f"CARTESIAN_POINT('',({','.join(map(_real, at))}))")

    def direction(self, along: Array) -> str:
        return self.add(f"DIRECTION('',({','.join(map(_real, along))}))")

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
        return self.add(f"CIRCLE('',{self.placement(center, axis, reference)},{_real(radius)})")

    def edge(self, start: str, end: str, curve: str) -> str:
        return self.add(f"EDGE_CURVE('',{start},{end},{curve},.T.)")


def step(fitted: Fitted, options: ExportOptions) -> bytes:
    """The file; raises `NothingToExportError` where there is nothing to trim."""
    primitive, extents = trimmed(fitted.recognition)
    patch = patch_of(primitive, extents)
    file = _File()
    surface = _surface(file, primitive, patch)
    faces = [
        file.add(f"ADVANCED_FACE('{primitive.kind}',({','.join(bounds)}),{surface},.T.)")
        for bounds in _bounds(file, patch)
    ]
    closed = isinstance(patch, Patch) and patch.is_closed
    shell = file.add(f"{'CLOSED' if closed else 'OPEN'}_SHELL('',({','.join(faces)}))")
    status = fitted.recognition.status
    name = primitive.kind if status == "fitted" else f"{primitive.kind} ({status})"
    _product(file, name, shell, extents, options.unit)
    return _part21(file, name).encode("ascii")


def _bounds(file: _File, patch: Patch | Pieces) -> list[list[str]]:
    """Of each face its outer bound, then those of its holes."""
    if isinstance(patch, Patch):
        return [[_bound(file, _revolved(file, patch))]]
    return [
        [_bound(file, _outlined(file, ring), outer=i == 0) for i, ring in enumerate(rings)] for rings in patch
    ]


def _bound(file: _File, loop: list[Edge], outer: bool = True) -> str:
    edges = [file.add(f"ORIENTED_EDGE('',*,*,{edge},{_flag(forward)})") for edge, forward in loop]
    boundary = file.add(f"EDGE_LOOP('',({','.join(edges)}))")
    return file.add(f"FACE_{'OUTER_' if outer else ''}BOUND('',{boundary},.T.)")


def _surface(file: _File, primitive: Primitive, patch: Patch | Pieces) -> str:
    if isinstance(primitive, Plane):
        where = file.placement(primitive.point, primitive.normal, basis(primitive.normal)[0])
        return file.add(f"PLANE('',{where})")
    assert isinstance(patch, Patch)
    rho, height = (float(value) for value in patch.profile(patch.v[0]))
    base = patch.origin if not isinstance(primitive, Cone) else patch.origin + height * patch.axis
    where = file.placement(base, patch.axis, patch.reference)
    match primitive:
        case Cylinder(radius=radius):
            return file.add(f"CYLINDRICAL_SURFACE('',{where},{_real(radius)})")
        case Cone(half_angle=half_angle):
            return file.add(f"CONICAL_SURFACE('',{where},{_real(rho)},{_real(half_angle)})")
        case Sphere(radius=radius):
            return file.add(f"SPHERICAL_SURFACE('',{where},{_real(radius)})")
        case Torus(major_radius=major, minor_radius=minor) if major > minor:
            return file.add(f"TOROIDAL_SURFACE('',{where},{_real(major)},{_real(minor)})")
    raise NothingToExportError("STEP has no torus whose major radius is not over the minor one")


def _outlined(file: _File, corners: Array) -> list[Edge]:
    """The straight edges of a ring: counter-clockwise about the normal, or clockwise around a hole."""
    vertices = [file.vertex(corner) for corner in corners]
    following = np.roll(np.arange(len(corners)), -1)
    return [
        (file.edge(vertices[i], vertices[j], file.line(corners[i], corners[j])), True)
        for i, j in enumerate(following)
    ]


def _revolved(file: _File, patch: Patch) -> list[Edge]:
    """The edges about a piece, counter-clockwise seen from outside: v0 forth, u1 up, v1 back, u0 down.

    Where the piece closes, the two edges across are one seam, run through both ways; where it shrinks to a
    point there is none.
    """
    (u0, u1), (v0, v1), (no_low, no_high) = patch.u, patch.v, patch.has_pole
    corners: dict[tuple[float, float], str] = {}

    def corner(u: float, v: float) -> str:
        u = u0 if patch.closed_u or (v == v0 and no_low) or (v == v1 and no_high) else u
        v = v0 if patch.closed_v else v
        if (u, v) not in corners:
            corners[u, v] = file.vertex(patch.at(u, v))
        return corners[u, v]

    def around(v: float) -> str:
        rho, height = (float(value) for value in patch.profile(v))
        curve = file.circle(patch.origin + height * patch.axis, patch.axis, patch.reference, rho)
        return file.edge(corner(u0, v), corner(u1, v), curve)

    up = file.edge(corner(u0, v0), corner(u0, v1), _meridian(file, patch, u0))
    other_up = up if patch.closed_u else file.edge(corner(u1, v0), corner(u1, v1), _meridian(file, patch, u1))
    low = None if no_low else around(v0)
    high = low if patch.closed_v else None if no_high else around(v1)
    loop = [(low, True), (other_up, True), (high, False), (up, False)]
    return [(edge, forward) for edge, forward in loop if edge is not None]


def _meridian(file: _File, patch: Patch, u: float) -> str:
    """The curve of constant u: a line, or a circle in the plane of the axis."""
    across = patch.direction(u)
    match patch.primitive:
        case Sphere(radius=radius):
            return file.circle(patch.origin, cross(across, patch.axis), across, radius)
        case Torus(major_radius=major, minor_radius=minor):
            return file.circle(patch.origin + major * across, cross(across, patch.axis), across, minor)
    return file.line(patch.at(u, patch.v[0]), patch.at(u, patch.v[1]))


def _product(file: _File, name: str, shell: str, extents: Extents, unit: str) -> None:
    """The units of the shell, and the product that a reader looks for."""
    model = file.add(f"SHELL_BASED_SURFACE_MODEL('',({shell}))")
    length = _length_unit(file, unit)
    angle = file.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    solid = file.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
    tolerance = _real(UNCERTAINTY * float(np.sqrt(extents.area)))
    uncertainty = file.add(
        f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({tolerance}),{length},'distance_accuracy_value','')"
    )
    context = file.add(
        f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({uncertainty}))"
        f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid}))REPRESENTATION_CONTEXT('',''))"
    )
    origin = file.placement(np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]))
    shape = file.add(f"MANIFOLD_SURFACE_SHAPE_REPRESENTATION('{name}',({origin},{model}),{context})")
    application = file.add("APPLICATION_CONTEXT('automotive design')")
    file.add(
        f"APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,{application})"
    )
    discipline = file.add(f"PRODUCT_CONTEXT('',{application},'mechanical')")
    product = file.add(f"PRODUCT('{name}','{name}','',({discipline}))")
    file.add(f"PRODUCT_RELATED_PRODUCT_CATEGORY('part','',({product}))")
    formation = file.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
    stage = file.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')")
    definition = file.add(f"PRODUCT_DEFINITION('design','',{formation},{stage})")
    defined = file.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
    file.add(f"SHAPE_DEFINITION_REPRESENTATION({defined},{shape})")


def _length_unit(file: _File, unit: str) -> str:
    if unit != "inch":
        prefix = {"mm": ".MILLI.", "m": "$"}[unit]
        return file.add(f"(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({prefix},.METRE.))")
    millimetre = file.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
    dimensions = file.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)")
    measure = file.add(f"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),{millimetre})")
    return file.add(f"(CONVERSION_BASED_UNIT('INCH',{measure})LENGTH_UNIT()NAMED_UNIT({dimensions}))")


def _part21(file: _File, name: str) -> str:
    header = [
        "ISO-10303-21;",
        "HEADER;",
        "FILE_DESCRIPTION(('a primitive recognised in a point cloud'),'2;1');",
        f"FILE_NAME('{name}','{EPOCH}',(''),(''),'primfit {version('primfit')}','primfit','');",
        f"FILE_SCHEMA(('{SCHEMA}'));",
        "ENDSEC;",
        "DATA;",
    ]
    return "\n".join([*header, *file.lines, "ENDSEC;", "END-ISO-10303-21;", ""])


def _flag(value: bool) -> str:
    return ".T." if value else ".F."


def _real(value: float) -> str:
    """A number as Part 21 wants it: a point always, a capital E."""
    mantissa, _, exponent = repr(float(value)).partition("e")
    mantissa = mantissa.removesuffix("0") if mantissa.endswith(".0") else mantissa
    point = "" if "." in mantissa else "."
    return f"{mantissa}{point}E{exponent}" if exponent else f"{mantissa}{point}"
