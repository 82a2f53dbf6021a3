"""Form errors: how far points deviate from the two reference features that ISO standards measure form by.

The least-squares feature minimizes the sum of squared distances, the minimum-zone feature the largest
distance; all numbers of either are free. The form error is the width of the zone between two offsets of the
feature that holds all points: its peak-to-valley deviation, the largest less the smallest signed distance.
Terms as in ISO 12781-1 (flatness: LSPL, MZPL), ISO 12180-1 (cylindricity: LSCY, MZCY) and ISO 12181-1
(roundness); cones, spheres and tori are measured alike.
"""

from dataclasses import dataclass

import numpy as np

from ..cloud.cloud import Cloud
from ..cloud.frame import Frame
from ..equality import ByValue
from ..errors import FailedFit, InvalidPointCloudError
from ..geometry.vectors import Array
from ..primitives.primitive import NO_ROWS, Primitive
from ..search.criteria import cheapest_minimum
from ..trial.trial import Trial
from ..zones.extreme import minimum_zone


@dataclass(frozen=True, eq=False)
class Reference(ByValue):
    """A reference feature, and how the points deviate from it, in input units.

    Attributes
    ----------
    form_error : peak to valley
    peak, valley : the largest and the smallest signed distance
    rms : root of the mean squared distance
    """

    primitive: Primitive
    form_error: float
    peak: float
    valley: float
    rms: float

    @classmethod
    def of(cls, primitive: Primitive, points: Array, frame: Frame) -> "Reference":
        """Of a feature and points (N, 3) in a frame."""
        distance = primitive.signed_distance(points)
        peak, valley = frame.scale * float(distance.max()), frame.scale * float(distance.min())
        rms = frame.scale * float(np.sqrt(np.mean(distance**2)))
        return cls(frame.restore(primitive), peak - valley, peak, valley, rms)


@dataclass(frozen=True, eq=False)
class Form(ByValue):
    """The form error of some points: `name` is flatness, cylindricity, ... ; see `Reference`.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> x, y = np.random.default_rng(0).random((2, 300))
    >>> plate = np.stack([x, y, np.where(np.arange(300) % 2, 0.001, -0.001)], axis=1)
    >>> form = primfit.form_errors(primfit.fit(plate))
    >>> form.name, round(form.minimum_zone.form_error, 6)
    ('flatness', 0.002)
    """

    name: str
    n_points: int
    least_squares: Reference | FailedFit
    minimum_zone: Reference | FailedFit


def form_of(primitive: Primitive, points: Array) -> Form:
    """The form error of points (N, 3) that a primitive was found in, from where it stands.

    The fits are those of the criteria `least_squares` and `minimum_zone`. A feature that cannot be had says
    why, as a `FailedFit`.
    """
    name = primitive.form
    try:
        cloud = Cloud.prepare(points, None, np.random.default_rng(0))
    except InvalidPointCloudError as error:
        failed = FailedFit(str(error))
        return Form(name, len(points), failed, failed)
    if len(cloud.working) < primitive.dof:
        failed = FailedFit(f"{len(cloud.working)} points do not determine a {primitive.kind}")
        return Form(name, len(points), failed, failed)
    start = cloud.frame.bring(primitive)
    end = cheapest_minimum(start, NO_ROWS, Trial(start.kind, cloud))
    least_squares = end if isinstance(end, FailedFit) else end.primitive
    best = start if isinstance(least_squares, FailedFit) else least_squares
    zone = minimum_zone([best], cloud)
    references = (_reference(found, start, cloud) for found in (least_squares, zone))
    return Form(name, len(points), *references)


def _reference(found: Primitive | FailedFit, start: Primitive, cloud: Cloud) -> Reference | FailedFit:
    """With the axis or normal turned to where that of the start points."""
    if isinstance(found, FailedFit):
        return found
    row = found.canonical(np.zeros(3)).row()
    if not found.has_sign and row[:3] @ start.row()[:3] < 0.0:
        row[:3] = -row[:3]
    return Reference.of(type(found).from_row(row), cloud.points, cloud.frame)
