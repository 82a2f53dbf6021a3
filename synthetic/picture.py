"""A picture of a sample of clouds, for the eye; needs matplotlib, which only this file imports."""

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from .clouds import SyntheticCloud

COLUMNS = 6
MOST_DRAWN = 3000
"""Points drawn of a cloud, a random sample."""
SURFACE, STRAY = "#14647d", "#d1495b"


class MissingMatplotlibError(ImportError):
    """matplotlib is not installed."""

    def __init__(self) -> None:
        super().__init__("a picture needs matplotlib: pip install 'matplotlib>=3.8', or leave out --picture")


def has_matplotlib() -> bool:
    """Is matplotlib installed?"""
    return find_spec("matplotlib") is not None


def require_matplotlib() -> None:
    """Raise `MissingMatplotlibError` before any work is done."""
    if not has_matplotlib():
        raise MissingMatplotlibError


def draw(clouds: Sequence[SyntheticCloud], path: Path) -> None:
    """Write a grid of these clouds as an image; raises `MissingMatplotlibError`."""
    require_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    columns = min(COLUMNS, len(clouds))
    rows = -(-len(clouds) // columns)
    figure = Figure(figsize=(2.6 * columns, 2.9 * rows), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    for place, cloud in enumerate(clouds):
        axes: Any = figure.add_subplot(rows, columns, place + 1, projection="3d")
        _draw_cloud(axes, cloud, np.random.default_rng(place))
    figure.savefig(path, metadata={"Software": None})


def title(cloud: SyntheticCloud) -> str:
    """Kind and size, then what was done to the cloud."""
    done = [cloud.perturbation] if cloud.perturbation else []
    if cloud.family == "benchmark" and cloud.exact_share < 1.0:
        done.append(f"{100 * cloud.exact_share:.0f}% exact")
    if cloud.noise and cloud.extent:
        done.append(f"noise {100 * cloud.noise / cloud.extent:.2g}%")
    if cloud.outlier_share:
        done.append(f"{100 * cloud.outlier_share:.0f}% out")
    if cloud.arc is not None:
        done.append(f"{cloud.arc:.0f}°")
    seen_by = f" ({cloud.sensor})" if cloud.sensor else ""
    return (
        f"{cloud.kind.replace('_', ' ')}{seen_by}, {len(cloud.points):,} points\n{', '.join(done) or 'clean'}"
    )


def _draw_cloud(axes: Any, cloud: SyntheticCloud, rng: np.random.Generator) -> None:
    """Seen from where it was scanned, or from a corner; equal scales, centred on the surface."""
    outliers = np.zeros(len(cloud.points), bool) if cloud.outliers is None else cloud.outliers
    surface = cloud.points[~outliers]
    low, high = surface.min(axis=0), surface.max(axis=0)
    center, half = (low + high) / 2, 0.52 * max(float((high - low).max()), 1e-300)
    chosen = rng.permutation(len(cloud.points))[:MOST_DRAWN]
    shown = (cloud.points[chosen] - center) / half
    size = 1.5 if len(chosen) > 1000 else 4.0 if len(chosen) > 150 else 10.0
    inside = np.abs(shown).max(axis=1) < 1.15
    for mask, color, label in ((~outliers[chosen], SURFACE, 1), (outliers[chosen], STRAY, 2)):
        axes.scatter(*shown[mask & inside].T, s=size, c=color, linewidths=0, zorder=label, depthshade=False)
    if cloud.stations is not None:
        x, y, z = cloud.stations[0] - center
        # Beside the station, not at it: a cloud seen exactly from there shows no depth.
        axes.view_init(
            elev=float(np.degrees(np.arctan2(z, np.hypot(x, y)))) + 20.0,
            azim=float(np.degrees(np.arctan2(y, x))) + 25.0,
        )
    axes.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1))
    axes.set_box_aspect((1, 1, 1), zoom=1.3)
    axes.set_axis_off()
    axes.set_title(title(cloud), fontsize=8, y=1.0)
