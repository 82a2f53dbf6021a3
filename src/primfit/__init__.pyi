from .app.engine.estimator import PrimitiveFitter
from .app.engine.fit import fit, read
from .app.engine.segments import Segment, Segments, fit_segments
from .app.exports import NothingToExportError, export, form_errors, residuals
from .app.exports.many import export_segments
from .app.exports.notebook import show, show_segments
from .app.exports.pictures import picture, plot
from .app.readers.cloud import Cloud
from .app.readers.errors import UnreadableFileError
from .fitting.answer.conformance import Check, Conformance
from .fitting.answer.form import Form
from .fitting.answer.residuals import Residuals
from .fitting.answer.result import Alternative, Attempt, Recognition
from .fitting.answer.values import Deviation, ErrorSummary, NoiseSummary
from .fitting.errors import InvalidOptionError, InvalidPointCloudError
from .fitting.names import KINDS
from .fitting.primitives import parameters
from .fitting.primitives.cone import Cone
from .fitting.primitives.cylinder import Cylinder
from .fitting.primitives.plane import Plane
from .fitting.primitives.primitive import Primitive
from .fitting.primitives.sphere import Sphere
from .fitting.primitives.torus import Torus
from .fitting.recognize import recognize
from .fitting.request.config import Config
from .fitting.request.constraints import Constraints, Direction, Range

__version__: str

__all__ = [
    "KINDS",
    "Alternative",
    "Attempt",
    "Check",
    "Cloud",
    "Cone",
    "Config",
    "Conformance",
    "Constraints",
    "Cylinder",
    "Deviation",
    "Direction",
    "ErrorSummary",
    "Form",
    "InvalidOptionError",
    "InvalidPointCloudError",
    "NoiseSummary",
    "NothingToExportError",
    "Plane",
    "Primitive",
    "PrimitiveFitter",
    "Range",
    "Recognition",
    "Residuals",
    "Segment",
    "Segments",
    "Sphere",
    "Torus",
    "UnreadableFileError",
    "__version__",
    "export",
    "export_segments",
    "fit",
    "fit_segments",
    "form_errors",
    "parameters",
    "picture",
    "plot",
    "read",
    "recognize",
    "residuals",
    "show",
    "show_segments",
]
