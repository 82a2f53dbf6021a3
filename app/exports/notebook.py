"""Answers in a notebook, as 3D pictures that can be turned; k3d draws them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from primfit.fitting.answer.residuals import Residuals
from primfit.fitting.answer.result import Recognition
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.names import Unit

from ..engine.names import Ids
from ..engine.segments import Segment
from .colors import ANCHORS, color_limit
from .fitted import Fitted, NothingToExportError, fitted_points
from .options import ExportOptions, unit_of
from .report.numbers import count
from .report.scene import UPRIGHT, Camera, shown
from .report.views import ISOMETRIC

if TYPE_CHECKING:
    from k3d.plot import Plot

MOST_POINTS = 1_000_000
"""So many points are drawn at most, a random sample: 16 MB that go to the browser."""

DOT, OUTLIER = 1 / 200, 1 / 80
"""Diameters of points, as shares of the size of what is shown: about 3 and 7 pixels."""

INK, PLAIN = 0x1D252E, 0x5B8FC9
SURFACE, BEST_TRY = 0x96A6BA, 0xB08D57
"""Of an accepted primitive, and of the best try of `no_fit`."""

APART = 0xE69F00
"""Of outliers: the orange of Okabe and Ito, which is not among the colors of residuals."""

SEE_THROUGH = 0.4
"""Opacity of the surface: points behind it are seen."""

FIELD_OF_VIEW = 60.0
"""Of the camera, from the lower to the upper edge [degrees]."""


def show(recognition: Recognition, points: Any = None) -> "Plot":
    """A 3D picture for a notebook, to be turned with the mouse: the points and the trimmed primitive.

    Points are colored by their signed residuals as in `residuals_ply`: blue inside, red outside. Outliers are
    larger, and orange. Of an `ambiguous` answer the first primitive is shown, of `no_fit` the best try, in
    brown. Where there is no primitive at all, the points alone are. Of a large cloud a million points are
    drawn.

    It needs k3d, which `pip install "primfit[notebook]"` brings along.

    Parameters
    ----------
    points : (N, 3) that were fitted; None where the answer still has them

    Returns
    -------
    The widget, which a notebook shows where it is the last value of a cell. `get_snapshot()` of it is a page
    in HTML that works without a network.

    Raises
    ------
    ImportError
        k3d is missing.
    InvalidOptionError
        There are no points.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> recognition = primfit.fit(primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar))
    >>> picture = recognition.show()
    >>> [drawn.name for drawn in picture.objects][:2]
    ['points', 'sphere']
    """
    fitted = fitted_points(recognition, points)
    if recognition.primitive is None:
        return _drawn({"": fitted}, "no fit")
    kind = recognition.primitive.kind
    title = {"ambiguous": f"ambiguous, first: {kind}", "no_fit": f"no fit, best try: {kind}"}
    return _drawn({kind: fitted}, title.get(recognition.status, f"{kind}, {recognition.status}"))


def show_segments(segments: Sequence[Segment]) -> "Plot":
    """A picture of all segments of a cloud, as `show` has it; colors end at the same residual for all.

    Segments that could not be fitted have no answer and are left out.

    Parameters
    ----------
    segments : what `fit_segments` gave, or some of it

    Raises
    ------
    ImportError
        k3d is missing.
    InvalidOptionError
        An answer has left its points behind, or the answers are in different units.
    NothingToExportError
        No segment has an answer.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> segments = primfit.fit_segments(np.vstack([points, points + 9.0]), [7] * 300 + [8] * 300)
    >>> [drawn.name for drawn in segments.show().objects if "sphere" in drawn.name]
    ['7 sphere', '8 sphere']
    """
    ids, parts = Ids(), {}
    for segment in segments:
        if segment.recognition is not None:
            fitted = fitted_points(segment.recognition)
            parts[ids.unique(_name(segment.label, segment.recognition))] = fitted
    if not parts:
        raise NothingToExportError("no segment has an answer to show")
    return _drawn(parts, count(len(parts), "segment"))


def _name(label: int | str, found: Recognition) -> str:
    kind = "no primitive" if found.primitive is None else found.primitive.kind
    return f"{label} {kind}" + ("" if found.status == "fitted" else f" ({found.status})")


@dataclass(frozen=True, eq=False)
class _Dots:
    """All points of a picture.

    Attributes
    ----------
    points : (N, 3)
    residuals : of them; NaN where there is no primitive
    origin : (3,) near the points, with the digits of float32, which is what k3d draws with
    limit : the residual at which the colors end [length]
    size : diagonal of the box about the inliers, about all points where there are none [length]
    """

    points: Array
    residuals: Residuals
    origin: Array
    limit: float
    size: float

    @classmethod
    def of(cls, parts: Iterable[Fitted]) -> Self:
        points, distance, inlier = map(np.concatenate, zip(*map(_columns, parts), strict=True))
        residuals = Residuals(distance, inlier)
        near = points[inlier] if inlier.any() else points
        low, high = near.min(axis=0), near.max(axis=0)
        origin = (low / 2.0 + high / 2.0).astype(np.float32).astype(np.float64)
        return cls(
            points, residuals, origin, color_limit(residuals) or 1.0, float(np.linalg.norm(high - low))
        )


def _columns(fitted: Fitted) -> tuple[Array, Array, np.ndarray]:
    """Points (N, 3), residuals (N,) and which of them are inliers (N,)."""
    n_points = len(fitted.points)
    if fitted.recognition.primitive is None:
        return fitted.points, np.full(n_points, np.nan), np.zeros(n_points, bool)
    return fitted.points, fitted.residuals.distance, fitted.residuals.inlier


def _drawn(parts: Mapping[str, Fitted], title: str) -> "Plot":
    """The widget: points, surfaces by their names, and a legend."""
    k3d = _k3d()
    dots = _Dots.of(parts.values())
    unit = unit_of([part.recognition for part in parts.values()], ExportOptions().unit)
    plot = k3d.plot(camera_fov=FIELD_OF_VIEW, camera_auto_fit=False)
    _add_points(k3d, plot, dots)
    for name, part in parts.items():
        _add_surface(k3d, plot, dots.origin, name, part)
    words = "<br>".join([title, *_legend(dots, unit)])
    plot += k3d.text2d(
        words,
        position=(0.02, 0.02),
        reference_point="lt",
        color=INK,
        is_html=True,
        label_box=False,
        name="legend",
    )
    (alone,) = parts.values() if len(parts) == 1 else (None,)
    plot.camera = _camera(dots, alone)
    return plot


def _k3d() -> Any:
    try:
        import k3d
    except ImportError as error:
        raise ImportError('a picture in 3D needs k3d: pip install "primfit[notebook]"') from error
    return k3d


def _add_points(k3d: Any, plot: Any, dots: _Dots) -> None:
    """Inliers by their residuals, outliers, and points without a primitive: what there is of each."""
    rows = shown(len(dots.points), MOST_POINTS)
    local, distance = dots.points[rows] - dots.origin, dots.residuals.distance[rows]
    inlier, plain = dots.residuals.inlier[rows], np.isnan(distance)
    colored = {
        "attribute": distance[inlier],
        "color_map": np.column_stack([np.linspace(0.0, 1.0, len(ANCHORS)), ANCHORS / 255.0]).ravel(),
        "color_range": [-dots.limit, dots.limit],
    }
    for name, mask, diameter, look in (
        ("points", inlier, DOT, colored | {"shader": "flat"}),
        ("points without a primitive", plain, DOT, {"color": PLAIN, "shader": "flat"}),
        ("outliers", ~inlier & ~plain, OUTLIER, {"color": APART, "shader": "3d"}),
    ):
        if mask.any():
            plot += k3d.points(
                local[mask], point_size=diameter * dots.size, name=name, translation=dots.origin, **look
            )


def _add_surface(k3d: Any, plot: Any, origin: Array, name: str, fitted: Fitted) -> None:
    """The trimmed primitive and its edges, if it has extents."""
    if fitted.recognition.extents is None:
        return
    vertices, triangles = fitted.shape.mesh(ExportOptions().chord_error)
    plot += k3d.mesh(
        vertices - origin,
        triangles.astype(np.uint32),
        color=BEST_TRY if fitted.recognition.status == "no_fit" else SURFACE,
        opacity=SEE_THROUGH,
        flat_shading=False,
        side="double",
        name=name,
        group=name,
        translation=origin,
    )
    for edge in fitted.shape.edges():
        plot += k3d.line(
            edge - origin, color=INK, shader="simple", name="edge", group=name, translation=origin
        )


def _legend(dots: _Dots, unit: Unit | None) -> list[str]:
    """What the colors mean, in lines of HTML."""
    outliers = int(np.sum(~dots.residuals.inlier & ~np.isnan(dots.residuals.distance)))
    colors = f"colors: signed distance [{unit}]" if unit else "colors: signed distance"
    lines = [colors] if dots.residuals.inlier.any() else []
    return lines + ([f"orange: {count(outliers, 'outlier')}"] if outliers else [])


def _camera(dots: _Dots, alone: Fitted | None) -> list[float]:
    """Place, target and upward direction, as in the isometric view of the report."""
    shape = None if alone is None or alone.recognition.extents is None else alone.shape
    axis, front = UPRIGHT if shape is None else shape.directions()
    camera = Camera.at(axis, front, *ISOMETRIC[1:])
    distance = dots.size / 2.0 / np.sin(np.radians(FIELD_OF_VIEW / 2.0))
    return [*(dots.origin + distance * camera.toward).tolist(), *dots.origin.tolist(), *camera.up.tolist()]
