"""primfit in Python: which geometric primitive is this point cloud, and with which parameters?

>>> import numpy as np, primfit
>>> sphere = primfit.Sphere(center=np.zeros(3), radius=2.0)
>>> azimuth, polar = np.random.default_rng(0).random((2, 500)) * np.array([[6.0], [3.0]])
>>> recognition = primfit.fit(sphere.surface(azimuth, polar))
>>> recognition.status, recognition.primitive.kind, round(recognition.primitive.radius, 9)
('fitted', 'sphere', 2.0)
"""

import lazy_loader

# The names are those of the file __init__.pyi; each is imported when it is first asked for.
_named, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__all__ += ["__version__"]


def __getattr__(name: str) -> object:
    if name != "__version__":
        return _named(name)
    from importlib.metadata import version  # takes longer than all else here

    return version("primfit")
