"""Pictures of an answer for whoever works in Python: one as SVG, and one that matplotlib draws."""

from typing import TYPE_CHECKING, Any

import numpy as np

from primfit.fitting.answer.result import Recognition
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.names import Unit
from primfit.fitting.plain import worded

from .colors import color_limit
from .fitted import Fitted, fitted_points
from .options import ExportOptions, unit_of
from .report import scene_svg
from .report.scene import shape_in, shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SURFACE, OUTLINE = "#96a6ba", "#1d252e"


def picture(recognition: Recognition, points: Any = None, *, unit: Unit | None = None) -> str:
    """The isometric view of the report as one SVG: the points and the trimmed primitive.

    Parameters
    ----------
    points : (N, 3) that were fitted; None where the answer still has them
    unit : of the coordinates, written beside the scale; None for that of the answer

    Raises
    ------
    InvalidOptionError
        There are no points, or the unit is unknown or another one than that of the answer.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> recognition = primfit.fit(primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar))
    >>> primfit.picture(recognition, unit="mm")[:4]
    '<svg'
    """
    how = ExportOptions(unit_of([recognition], unit))
    return scene_svg(fitted_points(recognition, points), how.unit)


def plot(recognition: Recognition, axes: "Axes | None" = None, points: Any = None) -> "Axes":
    """Draw the points in 3D, colored by their residuals, with the trimmed primitive and its outline.

    It needs matplotlib, which `pip install "primfit[plot]"` brings along. Of a large cloud 3,000 points are
    drawn. Where the answer has no fit, the points alone are.

    Parameters
    ----------
    axes : of matplotlib, in 3D; None makes a new figure
    points : (N, 3) that were fitted; None where the answer still has them

    Returns
    -------
    The axes, for titles and the like; `axes.figure.savefig("cloud.png")` writes the picture.

    Raises
    ------
    ImportError
        matplotlib is missing.
    InvalidOptionError
        There are no points.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> recognition = primfit.fit(primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar))
    >>> axes = recognition.plot()
    >>> axes.get_title()
    'sphere, fitted'
    """
    try:
        from matplotlib import pyplot
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]
    except ImportError as error:
        raise ImportError('a plot needs matplotlib: pip install "primfit[plot]"') from error
    fitted = fitted_points(recognition, points)
    rows = shown(len(fitted.points))
    drawn: Any = pyplot.figure().add_subplot(projection="3d") if axes is None else axes
    shape = shape_in(fitted)
    if shape is not None:
        drawn.add_collection3d(Poly3DCollection(shape.pieces(), facecolor=SURFACE, alpha=0.25))
        for edge in shape.edges():
            drawn.plot(*edge.T, color=OUTLINE, linewidth=1.0)
    _scatter(drawn, fitted, rows)
    status = recognition.status
    title = worded(status) if status == "no_fit" else f"{fitted.primitive.kind}, {status}"
    names = (_with(axis, recognition) for axis in "xyz")
    drawn.set(**dict(zip(("xlabel", "ylabel", "zlabel"), names, strict=True)), title=title)
    drawn.set_aspect("equal")
    return drawn


def _scatter(axes: Any, fitted: Fitted, rows: np.ndarray) -> None:
    """The points of these rows, with a bar that says what their colors mean."""
    points: Array = fitted.points[rows]
    if fitted.recognition.status == "no_fit":
        axes.scatter(*points.T, s=4.0, color=SURFACE)
        return
    limit = color_limit(fitted.residuals) or 1.0
    colors = {"c": fitted.residuals.distance[rows], "cmap": "RdBu_r", "vmin": -limit, "vmax": limit}
    dots = axes.scatter(*points.T, s=4.0, **colors)
    axes.figure.colorbar(dots, ax=axes, shrink=0.6, label=_with("signed distance", fitted.recognition))


def _with(name: str, recognition: Recognition) -> str:
    """The name of an axis of lengths, with their unit where it is known."""
    return f"{name} [{recognition.unit}]" if recognition.unit else name
