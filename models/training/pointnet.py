"""The rival design, trained and scored on the same clouds:  python -m primfit.models.training.pointnet

A small PointNet (Qi et al., CVPR 2017): one network for every point, then the largest and the mean value over
the points. It sees 256 points, each by numbers that no rigid motion changes. It is compared, not shipped.
"""

import json
import time

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from ..network import softmax
from ..rough import KINDS
from .dataset import make_dataset
from .metrics import metrics
from .network import fit, options, predict, temperature


class PointNet(nn.Module):
    def __init__(self, inputs: int) -> None:
        super().__init__()
        self.each = nn.Sequential(nn.Linear(inputs, 48), nn.ReLU(), nn.Linear(48, 96), nn.ReLU())
        self.all = nn.Sequential(nn.Linear(192, 96), nn.ReLU(), nn.Dropout(0.1), nn.Linear(96, len(KINDS)))

    def forward(self, points: torch.Tensor) -> torch.Tensor:
        each = self.each(points)
        pooled: torch.Tensor = self.all(torch.cat([each.amax(dim=1), each.mean(dim=1)], dim=1))
        return pooled


def invariant(clouds: NDArray[np.float32]) -> torch.Tensor:
    """(M, N, 6) -> (M, N, 11): each point from its cloud's principal axes and its normals', up to sign.

    Absolute coordinates of the point and of its normal along the principal axes of the points; of its normal
    along those of the normals; its distance to the centroid; and |x . n|.
    """
    points, normals = clouds[..., :3], clouds[..., 3:]
    axes = np.linalg.eigh(points.transpose(0, 2, 1) @ points)[1]
    turned = np.linalg.eigh(normals.transpose(0, 2, 1) @ normals)[1]
    parts = [
        np.abs(points @ axes),
        np.abs(normals @ axes),
        np.abs(normals @ turned),
        np.linalg.norm(points, axis=2, keepdims=True),
        np.abs(np.sum(points * normals, axis=2, keepdims=True)),
    ]
    return torch.from_numpy(np.concatenate(parts, axis=2).astype(np.float32))


def main(arguments: list[str] | None = None) -> None:
    given = options(__doc__).parse_args(arguments)
    torch.manual_seed(given.seed)
    torch.set_num_threads(1)
    data, validation, test = (
        make_dataset(seed, n, processes=given.processes, cache=given.cache)
        for seed, n in (
            (given.seed, given.clouds),
            (given.seed + 2, given.calibration),
            (given.seed + 1, given.held_back),
        )
    )
    start = time.perf_counter()
    inputs = invariant(data.points)
    model = PointNet(inputs.shape[-1])
    known = (invariant(validation.points), validation.labels)
    curves = fit(model, inputs, data.labels, known, given.epochs)
    t = temperature(predict(model, known[0]), validation.labels)
    scores = metrics(softmax(predict(model, invariant(test.points)) / t), test)
    weights = sum(values.numel() for values in model.parameters())
    if given.curves:
        given.curves.write_text(json.dumps(curves), encoding="utf-8")
    seconds = round(time.perf_counter() - start)
    print(json.dumps({"weights": weights, "seconds": seconds, "temperature": t, **scores}, indent=2))


if __name__ == "__main__":
    main()
