"""What an answer says of distances and of noise, as values; `fitting.answer.figures` makes them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ErrorSummary:
    """Orthogonal distances of all points to the primitive, in the unit of the input.

    Attributes
    ----------
    rms, mean, p95, max : of the absolute distances
    zone : largest less smallest signed distance, the form error: the width of the zone between two offsets of
        the surface that holds all points. Flatness, sphericity, cylindricity under the criterion asked for
    relative_mean : mean over the bounding-box diagonal (the SHREC 2022 track's mean fitting error)
    inlier_rms : rms of the points not rejected as outliers
    inlier_zone : as `zone`, of those points only
    inlier_share : share of the points not rejected as outliers

    Examples
    --------
    >>> import primfit
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.5]]
    >>> error = primfit.fit(corners, kinds=["plane"], criterion="least_squares").error
    >>> 0.0 < error.rms < error.max < error.zone
    True
    """

    rms: float
    mean: float
    p95: float
    max: float
    zone: float
    relative_mean: float
    inlier_rms: float
    inlier_zone: float
    inlier_share: float


@dataclass(frozen=True)
class Deviation:
    """A deviation that neighboring points share, in the unit of the input.

    Attributes
    ----------
    size : rms of the deviation
    range : distance over which points share it

    Examples
    --------
    >>> import numpy as np, primfit
    >>> x, y = np.random.default_rng(0).random((2, 2000))
    >>> points = np.stack([x, y, 0.01 * np.sin(9.0 * x)], axis=1)
    >>> smooth = primfit.fit(points, kinds=["plane"], tolerance=0.1).noise.smooth
    >>> isinstance(smooth, primfit.Deviation), 0.003 < smooth.size < 0.03
    (True, True)
    """

    size: float
    range: float


@dataclass(frozen=True)
class NoiseSummary:
    """How the points that were judged scatter about a primitive, in the unit of the input.

    Some lie exactly on it, most with noise, some anywhere.

    Attributes
    ----------
    scale : standard deviation of the noise of the points that are neither exact nor outliers; 0 where there
        are none
    exact_share : share of the points that lie on the surface within the rounding of the coordinates; 0 where
        that many could lie there by accident
    outlier_share : share of the points that are more likely to be anywhere than on the surface
    quantisation_step : step that the decimal coordinates differ by multiples of, None where there is none
    correlated : the part of the noise that neighbors share, rough as sensors make it; None where it does not
        show
    smooth : a smooth deviation of the cloud from the surface, as a bowed part or a wrong shape has; None
        where it does not show

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> noise = primfit.fit(points + np.random.default_rng(1).normal(0.0, 0.01, (300, 3))).noise
    >>> 0.008 < noise.scale < 0.012, noise.exact_share
    (True, 0.0)
    """

    scale: float
    exact_share: float
    outlier_share: float
    quantisation_step: float | None
    correlated: Deviation | None = None
    smooth: Deviation | None = None
