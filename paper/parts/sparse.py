"""Occupied cells of a grid, and convolutions on them, in plain torch.

As MinkowskiEngine does it (Choy et al., CVPR 2019): for each of the 27 steps to a cell around another, the
features of all cells that have an occupied neighbor there are gathered, multiplied by the weights of the
step, and added up where they lead. Of 27 neighbors 5 to 8 are occupied.
"""

from dataclasses import dataclass
from typing import Any

import torch
from torch.nn import functional

STEPS = 27


@dataclass(frozen=True, eq=False)
class Bags:
    """Which rows are added up for each result: `rows` from `starts` of a result to that of the next."""

    rows: torch.Tensor
    starts: torch.Tensor

    @staticmethod
    def of(places: torch.Tensor, count: int) -> "Bags":
        """Rows that go to places 0 .. count - 1."""
        held = torch.bincount(places, minlength=count)
        return Bags(torch.argsort(places, stable=True), held.cumsum(0) - held)

    def sums(self, rows: torch.Tensor) -> torch.Tensor:
        """Of rows (P, C), one for each result."""
        return functional.embedding_bag(self.rows, rows, self.starts, mode="sum")


@dataclass(frozen=True, eq=False)
class Pairs:
    """Occupied neighbors, in order of the step: from which row of the features to which of the results.

    Attributes
    ----------
    inputs, outputs : (P,) rows
    counts : how many pairs each of the 27 steps has
    by_input, by_output : the pairs of each row
    """

    inputs: torch.Tensor
    outputs: torch.Tensor
    counts: list[int]
    by_input: Bags
    by_output: Bags

    @staticmethod
    def of(neighbors: torch.Tensor, inputs: int) -> "Pairs":
        """From rows of neighbors (M, 27), which are `inputs` where a cell is empty."""
        rows = neighbors.T.contiguous()
        step, output = (rows < inputs).nonzero(as_tuple=True)
        taken = rows[step, output]
        counts = torch.bincount(step, minlength=STEPS).tolist()
        return Pairs(taken, output, counts, Bags.of(taken, inputs), Bags.of(output, len(neighbors)))


class Convolved(torch.autograd.Function):
    """Features (M, C) by weights (27, C, D) over pairs: (N, D)."""

    @staticmethod
    def forward(ctx: Any, features: torch.Tensor, weights: torch.Tensor, pairs: Pairs) -> torch.Tensor:
        gathered = features[pairs.inputs]
        ctx.save_for_backward(gathered, weights)
        ctx.pairs = pairs
        parts = zip(gathered.split(pairs.counts), weights, strict=True)
        return pairs.by_output.sums(torch.cat([part @ weight for part, weight in parts]))

    @staticmethod
    def backward(ctx: Any, *gradients: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, None]:
        gathered, weights = ctx.saved_tensors
        counts = ctx.pairs.counts
        split = gradients[0][ctx.pairs.outputs].split(counts)
        of_features = torch.cat([part @ weight.T for part, weight in zip(split, weights, strict=True)])
        of_weights = [a.T @ b for a, b in zip(gathered.split(counts), split, strict=True)]
        return ctx.pairs.by_input.sums(of_features), torch.stack(of_weights), None


def convolved(features: torch.Tensor, weights: torch.Tensor, pairs: Pairs) -> torch.Tensor:
    """`Convolved`, with the types of its result."""
    result: torch.Tensor = Convolved.apply(features, weights, pairs)
    return result


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
        """The places of cells (N, 4) in a table with a border of one cell on each side."""
        wide = self.side + 2
        return (cells + torch.tensor([0, 1, 1, 1])) @ torch.tensor([wide**3, wide**2, wide, 1])

    def coarser(self) -> tuple["Grid", torch.Tensor]:
        """The grid of cells twice as large, and which of them holds each of these cells."""
        return occupied(self.cells // torch.tensor([1, 2, 2, 2]), -(-self.side // 2), self.clouds)

    def neighbors(self, coarse: "Grid | None" = None) -> torch.Tensor:
        """Rows (N, 27) of the cells around each, or around the first corner of each coarser cell, if given.

        M where a cell is empty. A step is a product of steps -1, 0, 1 along x, y, z, in this order.
        """
        wide = self.side + 2
        table = torch.full((self.clouds * wide**3,), len(self.cells))
        table[self.keys(self.cells)] = torch.arange(len(self.cells))
        middle = self.cells if coarse is None else coarse.cells * torch.tensor([1, 2, 2, 2])
        steps = torch.cartesian_prod(*[torch.tensor([-1, 0, 1])] * 3) @ torch.tensor([wide**2, wide, 1])
        return table[self.keys(middle)[:, None] + steps]

    def pairs(self, coarse: "Grid | None" = None) -> Pairs:
        """The same without the empty ones."""
        return Pairs.of(self.neighbors(coarse), len(self.cells))


def occupied(cells: torch.Tensor, side: int, clouds: int) -> tuple[Grid, torch.Tensor]:
    """The grid of cells (N, 4), each of them once, and in which of its rows each is."""
    _, row = torch.unique(Grid(cells, side, clouds).keys(cells), return_inverse=True)
    unique = torch.empty((int(row.max()) + 1, 4), dtype=torch.int64)
    unique[row] = cells
    return Grid(unique, side, clouds), row
