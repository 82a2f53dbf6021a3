"""Signed values as colors: from blue over nearly white to red, which people of any color vision tell apart.

Source: the 11 classes of "RdBu" of ColorBrewer (Harrower and Brewer, "ColorBrewer.org", The Cartographic
Journal 40, 2003), reversed, with straight lines between them in sRGB.
"""

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.answer.residuals import Residuals
from primfit.fitting.geometry.vectors import Array

_CLASSES = "053061 2166ac 4393c3 92c5de d1e5f0 f7f7f7 fddbc7 f4a582 d6604d b2182b 67001f"
ANCHORS = np.array([list(bytes.fromhex(color)) for color in _CLASSES.split()], np.float64)
"""Colors (11, 3) in sRGB, in [0, 255], of evenly spaced values from the lowest to the highest."""

SATURATED = 99.0
"""Per cent of the inliers whose colors are not those of the ends."""


def color_limit(residuals: Residuals) -> float:
    """Magnitude of the residual at which the colors end, and beyond which they stay the same [length]."""
    inlying = np.abs(residuals.distance[residuals.inlier])
    return float(np.percentile(inlying, SATURATED)) or float(inlying.max()) if len(inlying) else 0.0


def diverging(values: Array, limit: float) -> NDArray[np.uint8]:
    """Colors (N, 3) in sRGB of values (N,): blue at -limit, nearly white at 0, red at limit."""
    share = values / limit if limit > 0.0 else np.zeros_like(values)
    place = (np.clip(share, -1.0, 1.0) + 1.0) / 2.0 * (len(ANCHORS) - 1)
    known = np.arange(len(ANCHORS))
    return np.stack([np.rint(np.interp(place, known, channel)) for channel in ANCHORS.T], axis=-1).astype(
        np.uint8
    )
