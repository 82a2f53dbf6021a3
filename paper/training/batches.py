"""What a network is shown of clouds: some of their points, turned and shifted as its method does it."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from ..parts.numbers import DIRECTION, POSITION
from ..parts.views import principal_views
from .clouds import Clouds
from .stages import Stage

SHIFTED = 0.2
SHIFT = 0.01
"""M5 moves such a share of the points along one coordinate, by so much [radii of the unit sphere, rms]."""


@dataclass(frozen=True, eq=False)
class Batch:
    """Inputs of a network, with the kinds (B,) or numbers (B, 8) that it should say."""

    inputs: torch.Tensor
    truth: torch.Tensor


def truth_of(stage: Stage, clouds: Clouds) -> torch.Tensor:
    """The kinds or the numbers of all clouds."""
    return torch.from_numpy(clouds.labels if stage.kind is None else clouds.numbers)


def drawn_batch(stage: Stage, clouds: Clouds, chosen: NDArray[np.int64], rng: np.random.Generator) -> Batch:
    """The chosen clouds to learn from: other points of them, and another pose, each time."""
    seen = rng.permutation(clouds.points.shape[1])[: stage.points]
    points = torch.from_numpy(clouds.points[chosen][:, seen].astype(np.float32))
    truth = truth_of(stage, clouds)[torch.from_numpy(chosen)]
    if stage.turned:
        turns = torch.from_numpy(rotations(len(chosen), stage.turned, rng))
        points = points @ turns.transpose(1, 2)
        truth = truth if stage.kind is None else turned_numbers(truth, turns)
    if stage.shifted:
        points = points + torch.from_numpy(shifts(points.shape, rng))
    if stage.network["design"] == "views":
        points = flipped(principal_views(points), rng)
    return Batch(points, truth)


def plain_batch(stage: Stage, clouds: Clouds, span: slice) -> Batch:
    """Clouds as they are asked about, to measure on."""
    points = torch.from_numpy(clouds.points[span, : stage.points].astype(np.float32))
    inputs = principal_views(points) if stage.network["design"] == "views" else points
    return Batch(inputs, truth_of(stage, clouds)[span])


def rotations(count: int, about: str, rng: np.random.Generator) -> NDArray[np.float32]:
    """Random rotations (count, 3, 3): "z" about that axis, "xyz" about all three, by uniform angles each."""
    result = np.broadcast_to(np.eye(3), (count, 3, 3))
    for axis in about:
        result = about_axis("xyz".index(axis), rng.uniform(0.0, 2 * np.pi, count)) @ result
    return result.astype(np.float32)


def about_axis(axis: int, angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotations (N, 3, 3) about a coordinate axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    result = np.broadcast_to(np.eye(3), (len(angles), 3, 3)).copy()
    result[:, i, i] = result[:, j, j] = np.cos(angles)
    result[:, j, i] = np.sin(angles)
    result[:, i, j] = -np.sin(angles)
    return result


def turned_numbers(numbers: torch.Tensor, turns: torch.Tensor) -> torch.Tensor:
    """Rows (B, 8) after rotations (B, 3, 3) about the origin."""
    result = numbers.clone()
    for part in (DIRECTION, POSITION):
        result[:, part] = (turns @ numbers[:, part, None])[..., 0]
    return result


def shifts(shape: torch.Size, rng: np.random.Generator) -> NDArray[np.float32]:
    """For some of the points a small step along one coordinate, which holds the two others."""
    moved = rng.random(shape[:2]) < SHIFTED
    along = np.eye(3)[rng.integers(3, size=shape[:2])]
    return (along * (moved * rng.normal(0.0, SHIFT, shape[:2]))[..., None]).astype(np.float32)


def flipped(pictures: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
    """Pictures of the clouds mirrored along their principal axes, each with an even chance.

    Mirroring along an axis flips the pictures along the two others, and the depths of its own.
    """
    for axis in range(3):
        if rng.random() < 0.5:
            pictures = mirrored(pictures, axis)
    return pictures


def mirrored(pictures: torch.Tensor, axis: int) -> torch.Tensor:
    """Pictures (B, 6, P, P) of clouds mirrored along one of their principal axes."""
    parts = []
    for along, seen in enumerate(pictures.split(2, dim=1)):
        if along == axis:
            parts.append(seen * torch.tensor([1.0, -1.0])[:, None, None])
        else:
            parts.append(seen.flip(2 if axis == min({0, 1, 2} - {along}) else 3))
    return torch.cat(parts, dim=1)
