"""The losses of M3 and M4, and which of them each kind sums.

Predicted and true numbers are rows (B, 8) as in `parts.numbers`; every loss is a mean over the batch.

What the paper leaves open, or prints in a way that cannot be meant, is chosen here:

- M3 tells a vector from its opposite, though both are the same axis. The truth is turned to the side of the
  prediction, except for the axis of a cone, which points into its nappe.
- M3's loss of a cone has a vertex, "r" and an angle: what a cone has beside the two is its axis.
- M4 divides the squared product of two vectors by their lengths, which a longer prediction makes as small as
  it likes: here by the squared lengths, which is the same for unit vectors.
- M4's kinds: position of a cylinder by the distance of a point to an axis, of all others by that of two
  points; all weights are 1.
"""

import torch
from torch.nn import functional

from .numbers import DIRECTION, LAYOUT, POSITION

SIGNED = ("cone",)
"""Kinds whose axis points one way only."""


def scalar_loss(found: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """Mean squared error."""
    return (found - truth).square().mean()


def point_loss(found: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """Mean distance between points (B, 3)."""
    return (found - truth).norm(dim=1).mean()


def vector_loss(found: torch.Tensor, truth: torch.Tensor, signed: bool) -> torch.Tensor:
    """M3:  1 - cos^8 + |v_G - v_O|^2  between vectors (B, 3)."""
    cosine = functional.cosine_similarity(found, truth, dim=1)
    if not signed:
        truth = torch.where(cosine[:, None] < 0.0, -truth, truth)
    return (1.0 - cosine**8 + (found - truth).square().sum(dim=1)).mean()


def axis_loss(found: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """M4:  1 - cos^2  between vectors (B, 3)."""
    return (1.0 - functional.cosine_similarity(found, truth, dim=1).square()).mean()


def point_to_axis_loss(found: torch.Tensor, position: torch.Tensor, direction: torch.Tensor) -> torch.Tensor:
    """M4: mean distance of points (B, 3) to axes through positions along unit directions."""
    offset = found - position
    along = (offset * direction).sum(dim=1, keepdim=True) * direction
    return (offset - along).norm(dim=1).mean()


def sizes_loss(kind: str, found: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """The sum of the scalar losses of radii and angles."""
    count = len(LAYOUT[kind][2])
    return sum((scalar_loss(found[:, 6 + k], truth[:, 6 + k]) for k in range(count)), torch.zeros(()))


def m3_loss(kind: str, found: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """Position by the point loss, direction by the vector loss, sizes by the scalar loss."""
    loss = point_loss(found[:, POSITION], truth[:, POSITION]) + sizes_loss(kind, found, truth)
    if LAYOUT[kind][0] is None:
        return loss
    return loss + vector_loss(found[:, DIRECTION], truth[:, DIRECTION], kind in SIGNED)


def m4_loss(kind: str, found: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """Position by a loss of points or axes, direction by that of axes, sizes by that of scalars."""
    if kind == "cylinder":
        position = point_to_axis_loss(found[:, POSITION], truth[:, POSITION], truth[:, DIRECTION])
    else:
        position = point_loss(found[:, POSITION], truth[:, POSITION])
    loss = position + sizes_loss(kind, found, truth)
    return loss if LAYOUT[kind][0] is None else loss + axis_loss(found[:, DIRECTION], truth[:, DIRECTION])
