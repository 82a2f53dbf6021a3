"""What a STEP file says beside the geometry: units, precision and the product."""

import numpy as np

from primfit.fitting.names import Unit

from ...readers.units import METERS
from .file import File, real

_PREFIXES = {"um": ".MICRO.", "mm": ".MILLI.", "cm": ".CENTI.", "m": "$", "km": ".KILO."}
_NAMES = {"inch": "INCH", "ft": "FOOT", "us-ft": "US_SURVEY_FOOT"}

UNCERTAINTY = 1e-7
"""Points closer than this share of the size are one: what readers join edges by."""


def product(file: File, name: str, shell: str, area: float, unit: Unit) -> None:
    """The units of the shell, whose surface has this area, and the product that a reader looks for."""
    model = file.add(f"SHELL_BASED_SURFACE_MODEL('',({shell}))")
    length = _length_unit(file, unit)
    angle = file.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    solid = file.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
    tolerance = real(UNCERTAINTY * float(np.sqrt(area)))
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
