"""What an answer says of its distances and of its noise, in input units."""

from ..cloud.cloud import Cloud
from ..fields.fields import Explanations
from ..geometry.vectors import Array
from ..primitives.primitive import Primitive
from ..solver.refine import distances
from ..verdict.evidence import Evidence
from . import _figures
from .values import Deviation, ErrorSummary, NoiseSummary

TAIL = 0.95
"""Share of the distances that `p95` is the largest of."""


def summarize(primitive: Primitive, evidence: Evidence) -> ErrorSummary:
    """The distances of all points from a primitive in the frame of the cloud, restored to input units."""
    points, scale = evidence.cloud.points, evidence.cloud.frame.scale
    judged = evidence.distance  # of the working points, which are all where they are as many
    if len(judged) != len(points):
        judged = distances(evidence.primitive, points)
    signed = judged if primitive is evidence.primitive else distances(primitive, points)
    rms, mean, p95, largest, zone, near, near_zone, share = _figures.figures(
        signed, judged, evidence.reach, TAIL
    )
    return ErrorSummary(
        rms=scale * rms,
        mean=scale * mean,
        p95=scale * p95,
        max=scale * largest,
        zone=scale * zone,
        relative_mean=mean / evidence.cloud.diagonal,
        inlier_rms=scale * near,
        inlier_zone=scale * near_zone,
        inlier_share=share,
    )


def summarize_noise(evidence: Evidence) -> NoiseSummary:
    """The noise about the judged primitive, restored to input units."""
    cloud = evidence.cloud
    share = evidence.noise.outlier_share * (1.0 - evidence.exact_share)
    rough, smooth = _deviations(evidence.explained, cloud)
    return NoiseSummary(
        scale=cloud.frame.scale * evidence.noise_scale,
        exact_share=evidence.exact_share,
        outlier_share=0.0 if evidence.trial.is_small else share,
        quantisation_step=cloud.step,
        correlated=rough,
        smooth=smooth,
    )


def _deviations(explained: Explanations | None, cloud: Cloud) -> tuple[Deviation | None, Deviation | None]:
    """The rough and the smooth one of the likeliest explanation, in input units."""
    if explained is None:
        return None, None
    best, unit = explained.likeliest, cloud.frame.scale

    def deviation(sizes: Array, ranges: Array) -> Deviation | None:
        if sizes[best] == 0.0:
            return None
        return Deviation(unit * float(sizes[best]), unit * cloud.extent * float(ranges[best]))

    return (
        deviation(explained.rough, explained.rough_range),
        deviation(explained.smooth, explained.smooth_range),
    )
