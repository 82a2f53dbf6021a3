"""What every generator hands out."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.primitives.primitive import Primitive

MOVES = (
    "white",
    "rough",
    "self-affine",
    "smooth",
    "line offsets",
    "line waves",
    "ripple",
    "radial bow",
    "form",
    "station shift",
    "depth steps",
)
"""Effects on a sensor's cloud that move all points; they are recorded as lengths."""
SHARES = ("edge fringe", "comet tail", "gross outliers")
"""Effects that concern some of the points; they are recorded as their share."""


@dataclass(frozen=True, eq=False)
class SyntheticCloud:
    """A labelled cloud, with what is known of how it was made, to group results by.

    Attributes
    ----------
    points : (N, 3) float64, in the unit of the cloud, as is every length below
    primitive : the truth; None for a foreign shape
    kind : the kind of the primitive, or the name of the foreign shape
    perturbation : "A0" to "A9" for benchmark clouds, else empty
    exact_share : share of the points that nothing moved from the surface, not even rounding
    family : "benchmark", "scanner", "sensor" or "foreign"
    noise : standard deviation of the noise along the ray, over the points that are no outliers; of a sensor's
        cloud their root mean square distance from the surface, by all effects; None where there is no single
        one (benchmark clouds: `exact_share` and the perturbation say more)
    correlation : distance, in rays of a scanner's grid, at which the noise is correlated by 1/e; 0: white
    outlier_share : share of the points that do not belong to the surface, mixed pixels included
    outliers : mask (N,) of those points, or None for benchmark clouds
    arc : degrees that the surface points cover: of azimuth around the axis, or of a cap of a sphere; None
        for planes, foreign shapes and benchmark clouds
    step : distance between two values that a coordinate can take, 0 where it is not rounded
    stations : positions (S, 3) of the scanner, or None
    station : which of them saw each point, (N,), or None
    extent : the diagonal of the bounding box of the surface points before noise, or None
    sensor : the name of the sensor, of a sensor's cloud (`synthetic.sensors`), else empty
    effects : of a sensor's cloud what each effect did, by name: the root mean square by which it moved the
        points or, of fringes, tails and gross outliers, the share of the points
    field_range : of a sensor's cloud the distance at which the largest of its random fields over the surface
        is correlated by 1/e, else None
    """

    points: NDArray[np.float64]
    primitive: Primitive | None
    kind: str
    perturbation: str = ""
    exact_share: float = 0.0
    family: str = "benchmark"
    noise: float | None = None
    correlation: float = 0.0
    outlier_share: float = 0.0
    outliers: NDArray[np.bool_] | None = None
    arc: float | None = None
    step: float = 0.0
    stations: NDArray[np.float64] | None = None
    station: NDArray[np.intp] | None = None
    extent: float | None = None
    sensor: str = ""
    effects: Mapping[str, float] = field(default_factory=dict)
    field_range: float | None = None

    @property
    def largest_effect(self) -> str:
        """The name of the effect that moved the points most; empty where effects are not recorded."""
        return max((name for name in MOVES if name in self.effects), key=self.effects.__getitem__, default="")
