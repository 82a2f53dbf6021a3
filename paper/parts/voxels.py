"""The voxel network of M4, in plain torch: convolutions on the occupied cells of a grid.

The paper names the network that MinkowskiEngine (Choy et al., CVPR 2019) trains on ModelNet, and the order of
its layers. A convolution looks at the 27 cells around a cell: rows of occupied neighbors are gathered by a
table of the grid, a row of zeros stands for each that is empty, and one product of matrices does the rest.
What is strided keeps the cells of a grid twice as coarse. Features of a cell are the mean coordinates of its
points. "Projected on the initial grid" is: each cell takes the features of the coarser cell that holds it.

The channels are about a third of the published ones, and the last have 128 instead of 1024.
"""

from dataclasses import dataclass
from itertools import pairwise

import torch
from torch import nn
from torch.nn import functional

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


@dataclass(frozen=True, eq=False)
class Grid:
    """Occupied cells of clouds, sorted by cloud.

    Attributes
    ----------
    cells : (M, 4) the number of the cloud, and the place along x, y, z
    side : cells along each axis
    clouds : how many
    """

    cells: torch.Tensor
    side: int
    clouds: int

    def keys(self, cells: torch.Tensor) -> torch.Tensor:
        """The places of cells (..., 4) in a table with a border of one cell on each side."""
        wide = self.side + 2
        cloud, x, y, z = cells.unbind(-1)
        return ((cloud * wide + x + 1) * wide + y + 1) * wide + z + 1

    def rows(self, cells: torch.Tensor) -> torch.Tensor:
        """In which row of `cells` others (..., 4) are found; M where they are empty."""
        table = torch.full((self.clouds * (self.side + 2) ** 3,), len(self.cells), dtype=torch.int64)
        table[self.keys(self.cells)] = torch.arange(len(self.cells))
        return table[self.keys(cells)]

    def coarser(self) -> "Grid":
        """The grid of cells twice as large."""
        return occupied(self.cells // torch.tensor([1, 2, 2, 2]), -(-self.side // 2), self.clouds)[0]

    def neighbors(self, coarse: "Grid | None" = None) -> torch.Tensor:
        """Rows (M, 27) of the cells around each; around the first corner of each coarser cell, if given."""
        around = self.cells if coarse is None else coarse.cells * torch.tensor([1, 2, 2, 2])
        steps = torch.cartesian_prod(*[torch.tensor([-1, 0, 1])] * 3)
        return self.rows(around[:, None] + functional.pad(steps, (1, 0)))


def occupied(cells: torch.Tensor, side: int, clouds: int) -> tuple[Grid, torch.Tensor]:
    """The grid of cells (N, 4), each of them once, and in which of its rows each is."""
    _, row = torch.unique(Grid(cells, side, clouds).keys(cells), return_inverse=True)
    unique = torch.empty((int(row.max()) + 1, 4), dtype=torch.int64)
    unique[row] = cells
    return Grid(unique, side, clouds), row


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
        self.linear = nn.Linear(27 * inputs, outputs, bias=False)
        self.after = nn.Sequential(nn.BatchNorm1d(outputs), nn.LeakyReLU(SLOPE, inplace=True))

    def forward(self, features: torch.Tensor, neighbors: torch.Tensor) -> torch.Tensor:
        empty = len(features)
        padded = functional.pad(features, (0, 0, 0, 1))
        gathered = functional.embedding(neighbors, padded, padding_idx=empty).flatten(1)
        result: torch.Tensor = self.after(self.linear(gathered))
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
        grids = [grid]
        for _ in COARSE:
            grids.append(grids[-1].coarser())
        strided = [fine.neighbors(coarse) for fine, coarse in pairwise(grids)]
        features = self.fine[0](self.each(means), grid.neighbors())
        levels = [features]
        for convolution, neighbors in zip(self.fine[1:], strided, strict=True):
            levels.append(convolution(levels[-1], neighbors))
        features = torch.cat([projected(*pair, grid) for pair in zip(levels, grids, strict=True)], dim=1)
        features = self.joined(features)
        for convolution, neighbors in zip(self.coarse, strided, strict=True):
            features = convolution(features, neighbors)
        numbers: torch.Tensor = self.whole(pooled(features, grids[-1]))
        return numbers


def projected(features: torch.Tensor, coarse: Grid, fine: Grid) -> torch.Tensor:
    """Features (M, C) of coarse cells as those of the cells of a finer grid that they hold."""
    ratio = fine.side // coarse.side
    return functional.embedding(coarse.rows(fine.cells // torch.tensor([1, ratio, ratio, ratio])), features)


def pooled(features: torch.Tensor, grid: Grid) -> torch.Tensor:
    """The largest and the mean features of the cells of each cloud, (B, 2 C)."""
    cloud = grid.cells[:, :1].expand(-1, features.shape[1])
    empty = torch.zeros((grid.clouds, features.shape[1]))
    largest = empty.scatter_reduce(0, cloud, features, "amax", include_self=False)
    return torch.cat([largest, empty.scatter_reduce(0, cloud, features, "mean", include_self=False)], dim=1)
