"""The voxel network of M4, in plain torch: convolutions on the occupied cells of a grid.

The paper names the network that MinkowskiEngine (Choy et al., CVPR 2019) trains on ModelNet, and the order of
its layers. A convolution looks at the 27 cells around a cell (`parts.sparse`); what is strided keeps the
cells of a grid twice as coarse. Features of a cell are the mean coordinates of its points. "Projected on the
initial grid" is: each cell takes the features of the coarser cell that holds it.

The channels are about a third of the published ones, and the last have 128 instead of 1024.
"""

from itertools import pairwise

import torch
from torch import nn
from torch.nn import functional

from .sparse import STEPS, Grid, Pairs, convolved, occupied

CELL = 0.05
"""Side of a cell, in radii of the unit sphere: the paper's."""
CELLS = 40
"""Along each axis."""
FINE = (16, 16, 24, 32)
"""Channels of the input convolution and of the three strided ones."""
JOINED = 32
"""Of a layer between the two, which MinkowskiEngine's has not: it halves the time of a step."""
COARSE = (32, 64, 128)
"""Of the three strided convolutions that follow."""
SLOPE = 0.01


def voxelized(points: torch.Tensor) -> tuple[Grid, torch.Tensor]:
    """The occupied cells of clouds (B, N, 3) in the unit sphere, and the mean points in them (M, 3)."""
    count, size, _ = points.shape
    places = ((points + 1.0) / CELL).floor().long().clamp(0, CELLS - 1)
    numbers = torch.arange(count)[:, None].expand(count, size)
    grid, row = occupied(torch.cat([numbers[..., None], places], dim=2).flatten(0, 1), CELLS, count)
    sums = torch.zeros((len(grid.cells), 3)).scatter_add_(0, row[:, None].expand(-1, 3), points.flatten(0, 1))
    return grid, sums / torch.bincount(row)[:, None]


class Convolution(nn.Module):
    """Over 27 cells, then batch normalization and LeakyReLU."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        bound = (STEPS * inputs) ** -0.5
        self.weights = nn.Parameter(torch.empty(STEPS, inputs, outputs).uniform_(-bound, bound))
        self.after = nn.Sequential(nn.BatchNorm1d(outputs), nn.LeakyReLU(SLOPE, inplace=True))

    def forward(self, features: torch.Tensor, pairs: Pairs) -> torch.Tensor:
        result: torch.Tensor = self.after(convolved(features, self.weights, pairs))
        return result


def connected(inputs: int, outputs: int) -> nn.Sequential:
    """A fully connected layer with batch normalization and LeakyReLU."""
    return nn.Sequential(
        nn.Linear(inputs, outputs, bias=False), nn.BatchNorm1d(outputs), nn.LeakyReLU(SLOPE, inplace=True)
    )


class VoxelNet(nn.Module):
    """From points (B, N, 3) in the unit sphere to numbers (B, outputs)."""

    def __init__(self, outputs: int, dropout: float = 0.0) -> None:
        super().__init__()
        self.each = connected(3, FINE[0])
        self.fine = nn.ModuleList(Convolution(a, b) for a, b in zip((FINE[0], *FINE[:-1]), FINE, strict=True))
        self.joined = connected(sum(FINE), JOINED)
        self.coarse = nn.ModuleList(
            Convolution(a, b) for a, b in zip((JOINED, *COARSE[:-1]), COARSE, strict=True)
        )
        self.whole = nn.Sequential(
            connected(2 * COARSE[-1], COARSE[-1]),
            nn.Dropout(dropout),
            connected(COARSE[-1], COARSE[-1]),
            nn.Dropout(dropout),
            nn.Linear(COARSE[-1], outputs),
        )

    def forward(self, points: torch.Tensor) -> torch.Tensor:
        grid, means = voxelized(points)
        grids, parents = pyramid(grid, len(COARSE))
        strided = [fine.pairs(coarse) for fine, coarse in pairwise(grids)]
        levels = [self.fine[0](self.each(means), grid.pairs())]
        for convolution, pairs in zip(self.fine[1:], strided, strict=True):
            levels.append(convolution(levels[-1], pairs))
        projected = [functional.embedding(*pair) for pair in zip(parents, levels[1:], strict=True)]
        features = torch.cat([levels[0], *projected], dim=1)
        features = self.joined(features)
        for convolution, pairs in zip(self.coarse, strided, strict=True):
            features = convolution(features, pairs)
        numbers: torch.Tensor = self.whole(pooled(features, grids[-1]))
        return numbers


def pyramid(grid: Grid, levels: int) -> tuple[list[Grid], list[torch.Tensor]]:
    """The grid and so many coarser ones; in which cell of each of these every cell of the first lies."""
    grids, parents = [grid], [torch.arange(len(grid.cells))]
    for _ in range(levels):
        coarse, row = grids[-1].coarser()
        grids.append(coarse)
        parents.append(row[parents[-1]])
    return grids, parents[1:]


def pooled(features: torch.Tensor, grid: Grid) -> torch.Tensor:
    """The largest and the mean features of the cells of each cloud, (B, 2 C)."""
    cloud = grid.cells[:, :1].expand(-1, features.shape[1])
    empty = torch.zeros((grid.clouds, features.shape[1]))
    largest = empty.scatter_reduce(0, cloud, features, "amax", include_self=False)
    return torch.cat([largest, empty.scatter_reduce(0, cloud, features, "mean", include_self=False)], dim=1)
