"""primfit in Python: which geometric primitive is this point cloud, and with which parameters?

>>> import numpy as np, primfit
>>> sphere = primfit.Sphere(center=np.zeros(3), radius=2.0)
>>> azimuth, polar = np.random.default_rng(0).random((2, 500)) * np.array([[6.0], [3.0]])
>>> recognition = primfit.fit(sphere.surface(azimuth, polar))
>>> recognition.status, recognition.primitive.kind, round(recognition.primitive.radius, 9)
('fitted', 'sphere', 2.0)
"""

from importlib.metadata import version

import lazy_loader

__version__ = version("primfit")

# The names are those of the file __init__.pyi; each is imported when it is first asked for.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__all__ += ["__version__"]
