"""What a STEP file says beside the geometry: units, precision and the product."""

from dataclasses import dataclass

import numpy as np

from primfit.fitting.names import Unit

from ...readers.units import METERS
from .file import File, quoted, real

_PREFIXES = {"um": ".MICRO.", "mm": ".MILLI.", "cm": ".CENTI.", "m": "$", "km": ".KILO."}
_NAMES = {"inch": "INCH", "ft": "FOOT", "us-ft": "US_SURVEY_FOOT"}

UNCERTAINTY = 1e-7
"""Points closer than this share of the size are one: what readers join edges by."""


@dataclass(frozen=True)
class Product:
    """References to what an assembly asks of a product: its definition, its shape, and the origin of that."""

    definition: str
    shape: str
    origin: str


def application(file: File) -> str:
    """Add what all products of a file share, and give the reference to it."""
    context = file.add("APPLICATION_CONTEXT('automotive design')")
    file.add(f"APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,{context})")
    return context


def product(file: File, application: str, name: str, shell: str | None, area: float, unit: Unit) -> Product:
    """Add the product that a reader looks for, and its units.

    Parameters
    ----------
    shell : reference to its geometry, or None for an assembly
    area : of its surface
    """
    context, origin = _context(file, area, unit), _origin(file)
    if shell is None:
        shape = file.add(f"SHAPE_REPRESENTATION({quoted(name)},({origin}),{context})")
    else:
        model = file.add(f"SHELL_BASED_SURFACE_MODEL('',({shell}))")
        shape = file.add(
            f"MANIFOLD_SURFACE_SHAPE_REPRESENTATION({quoted(name)},({origin},{model}),{context})"
        )
    discipline = file.add(f"PRODUCT_CONTEXT('',{application},'mechanical')")
    product = file.add(f"PRODUCT({quoted(name)},{quoted(name)},'',({discipline}))")
    file.add(f"PRODUCT_RELATED_PRODUCT_CATEGORY('part','',({product}))")
    formation = file.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
    stage = file.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')")
    definition = file.add(f"PRODUCT_DEFINITION('design','',{formation},{stage})")
    defined = file.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
    file.add(f"SHAPE_DEFINITION_REPRESENTATION({defined},{shape})")
    return Product(definition, shape, origin)


def place(file: File, part: Product, name: str, whole: Product) -> None:
    """Make a product a part of an assembly, where its coordinates say."""
    use = file.add(
        f"NEXT_ASSEMBLY_USAGE_OCCURRENCE({quoted(name)},{quoted(name)},'',{whole.definition},{part.definition},$)"
    )
    used = file.add(f"PRODUCT_DEFINITION_SHAPE('','',{use})")
    move = file.add(f"ITEM_DEFINED_TRANSFORMATION('','',{whole.origin},{part.origin})")
    relation = file.add(
        f"(REPRESENTATION_RELATIONSHIP('','',{part.shape},{whole.shape})"
        f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({move})SHAPE_REPRESENTATION_RELATIONSHIP())"
    )
    file.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{used})")


def _origin(file: File) -> str:
    return file.placement(np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]))


def _context(file: File, area: float, unit: Unit) -> str:
    """The units of a shape whose surface has this area, and its precision."""
    length = _length_unit(file, unit)
    angle = file.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    solid = file.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
    tolerance = real(UNCERTAINTY * float(np.sqrt(area)))
    uncertainty = file.add(
        f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({tolerance}),{length},'distance_accuracy_value','')"
    )
    return file.add(
        f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({uncertainty}))"
        f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid}))REPRESENTATION_CONTEXT('',''))"
    )


def _length_unit(file: File, unit: Unit) -> str:
    if unit in _PREFIXES:
        return file.add(f"(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({_PREFIXES[unit]},.METRE.))")
    millimeter = file.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
    dimensions = file.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)")
    length = real(METERS[unit] / METERS["mm"])
    measure = file.add(f"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({length}),{millimeter})")
    return file.add(
        f"(CONVERSION_BASED_UNIT('{_NAMES[unit]}',{measure})LENGTH_UNIT()NAMED_UNIT({dimensions}))"
    )
