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

from app.engine import fit
from app.exports import NothingToExportError, export, form_errors, residuals
from app.segments import Segment, fit_segments
from fitting.config import Config
from fitting.constraints import Constraints
from fitting.errors import InvalidOptionError, InvalidPointCloudError
from fitting.form import Form
from fitting.primitives import KINDS, Cone, Cylinder, Plane, Primitive, Sphere, Torus, parameters
from fitting.recognize import recognize
from fitting.residuals import Residuals
from fitting.result import Alternative, Attempt, Deviation, ErrorSummary, NoiseSummary, Recognition

if TYPE_CHECKING:
    from app.estimator import PrimitiveFitter

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
    from app.estimator import PrimitiveFitter

    return PrimitiveFitter
