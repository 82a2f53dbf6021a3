"""primfit in Python: which geometric primitive is this point cloud, and with which parameters?

>>> import numpy as np, primfit
>>> sphere = primfit.Sphere(center=np.zeros(3), radius=2.0)
>>> azimuth, polar = np.random.default_rng(0).random((2, 500)) * np.array([[6.0], [3.0]])
>>> recognition = primfit.fit(sphere.surface(azimuth, polar))
>>> recognition.status, recognition.primitive.kind, round(recognition.primitive.radius, 9)
('fitted', 'sphere', 2.0)
"""

from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from primfit.app.engine.fit import fit
from primfit.app.engine.segments import Segment, fit_segments
from primfit.app.exports import NothingToExportError, export, form_errors, residuals
from primfit.fitting.answer.residuals import Residuals
from primfit.fitting.answer.result import Alternative, Attempt, Recognition
from primfit.fitting.answer.values import Deviation, ErrorSummary, NoiseSummary
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError
from primfit.fitting.form import Form
from primfit.fitting.primitives import KINDS, Cone, Cylinder, Plane, Primitive, Sphere, Torus, parameters
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import Constraints

if TYPE_CHECKING:
    from primfit.app.engine.estimator import PrimitiveFitter

__version__ = version("primfit")

__all__ = [
    "KINDS",
    "Alternative",
    "Attempt",
    "Cone",
    "Config",
    "Constraints",
    "Cylinder",
    "Deviation",
    "ErrorSummary",
    "Form",
    "InvalidOptionError",
    "InvalidPointCloudError",
    "NoiseSummary",
    "NothingToExportError",
    "Plane",
    "Primitive",
    "PrimitiveFitter",
    "Recognition",
    "Residuals",
    "Segment",
    "Sphere",
    "Torus",
    "__version__",
    "export",
    "fit",
    "fit_segments",
    "form_errors",
    "parameters",
    "recognize",
    "residuals",
]


def __getattr__(name: str) -> Any:
    """`PrimitiveFitter` when it is first asked for: scikit-learn would double the time of the import."""
    if name != "PrimitiveFitter":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from primfit.app.engine.estimator import PrimitiveFitter

    return PrimitiveFitter
