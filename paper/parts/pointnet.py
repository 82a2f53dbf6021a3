"""PointNet (Qi et al., "PointNet: Deep learning on point sets", CVPR 2017), for M3 and M5.

One network for every point, between two alignment nets: the first turns the points, the second their
features; then the largest value of each feature over the points, and fully connected layers. The widths are
shares of those published, which are for GPUs: who uses it says which.
"""

from dataclasses import dataclass

import torch
from torch import nn


@dataclass(frozen=True)
class Widths:
    """Features after each layer.

    Attributes
    ----------
    aligning : of a point in both alignment nets; the layer after their maximum has half of the last
    first : of a point before its features are aligned
    second : of a point after that; the last is that of the cloud
    whole : of the cloud, by the fully connected layers
    """

    aligning: tuple[int, ...] = (32, 64, 128)
    first: tuple[int, ...] = (48, 48)
    second: tuple[int, ...] = (48, 96, 384)
    whole: tuple[int, ...] = (256,)


def layers(inputs: int, widths: tuple[int, ...]) -> nn.Sequential:
    """Fully connected, each with batch normalization and ReLU."""
    made: list[nn.Module] = []
    for width in widths:
        made += [nn.Linear(inputs, width, bias=False), nn.BatchNorm1d(width), nn.ReLU(inplace=True)]
        inputs = width
    return nn.Sequential(*made)


def largest(each: nn.Module, points: torch.Tensor) -> torch.Tensor:
    """Of points (B, N, C) the largest features (B, D)."""
    count, size, _ = points.shape
    features: torch.Tensor = each(points.flatten(0, 1))
    return features.view(count, size, -1).max(dim=1).values


class AlignmentNet(nn.Module):
    """From points (B, N, C) to matrices (B, C, C); before training, to identities."""

    def __init__(self, size: int, widths: tuple[int, ...]) -> None:
        super().__init__()
        self.size = size
        self.each = layers(size, widths)
        self.whole = layers(widths[-1], (widths[-1] // 2,))
        self.matrix = nn.Linear(widths[-1] // 2, size * size)
        nn.init.zeros_(self.matrix.weight)
        nn.init.zeros_(self.matrix.bias)

    def forward(self, points: torch.Tensor) -> torch.Tensor:
        matrices: torch.Tensor = self.matrix(self.whole(largest(self.each, points)))
        return matrices.view(-1, self.size, self.size) + torch.eye(self.size)


class PointNet(nn.Module):
    """From points (B, N, 3) to numbers (B, outputs)."""

    def __init__(self, outputs: int, widths: Widths = Widths(), dropout: float = 0.0) -> None:
        super().__init__()
        self.turn = AlignmentNet(3, widths.aligning)
        self.first = layers(3, widths.first)
        self.align = AlignmentNet(widths.first[-1], widths.aligning)
        self.second = layers(widths.first[-1], widths.second)
        self.whole = layers(widths.second[-1], widths.whole)
        self.dropout = nn.Dropout(dropout)
        self.last = nn.Linear(widths.whole[-1], outputs)
        self.unlike = torch.zeros(())

    def forward(self, points: torch.Tensor) -> torch.Tensor:
        count, size, _ = points.shape
        points = points @ self.turn(points)
        features = self.first(points.flatten(0, 1)).view(count, size, -1)
        matrices = self.align(features)
        self.unlike = unlike_rotations(matrices)
        pooled = largest(self.second, features @ matrices)
        numbers: torch.Tensor = self.last(self.dropout(self.whole(pooled)))
        return numbers


def unlike_rotations(matrices: torch.Tensor) -> torch.Tensor:
    """Mean of |1 - A A^T|^2 over matrices (B, C, C), which training keeps small (equation 2 there)."""
    difference = torch.eye(matrices.shape[-1]) - matrices @ matrices.transpose(1, 2)
    return difference.square().sum(dim=(1, 2)).mean()
