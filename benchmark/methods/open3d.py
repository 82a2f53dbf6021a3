"""Open3D: RANSAC for planes, the only primitive that it fits."""

import numpy as np
import open3d

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.plane import Plane

from ..measures import diagonal
from . import Answer

THRESHOLD = 0.005
"""Largest distance of an inlier, as a share of the cloud's diagonal."""

ITERATIONS = 1000
SAMPLE = 3


class Open3d:
    """`segment_plane`, which ends with least squares on the inliers."""

    name = "open3d"
    package = "open3d-cpu"
    decides_kind = False
    kinds = ("plane",)
    settings = (
        f"segment_plane with inliers within {THRESHOLD:.1%} of the bounding box's diagonal, samples of "
        f"{SAMPLE} points, at most {ITERATIONS} iterations, its own rule for when to stop, a fixed seed"
    )

    def fit(self, points: Array, kind: str | None) -> Answer:
        if len(points) < SAMPLE:
            return Answer("no_fit", None, f"segment_plane needs {SAMPLE} points")
        open3d.utility.random.seed(0)
        cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
        equation, _ = cloud.segment_plane(THRESHOLD * diagonal(points), SAMPLE, ITERATIONS)
        normal, offset = np.array(equation[:3]), float(equation[3])
        if not normal.any():
            return Answer("no_fit", None, "segment_plane found none")
        return Answer("fitted", Plane(normal, -offset * normal / (normal @ normal)))
