"""Images of a cloud along its principal directions, and the network of M6 that looks at them.

The paper turns the first principal axis to z and takes "images from the principal directions"; what these
show, and how large they are, it does not say. Here a cloud gives one picture of six channels: for each of
the three directions how many points a pixel holds, as log(1 + n) over the largest, and how deep they lie on
average. An axis points to where the third moment of the points along it is positive.

The layers are those of AlexNet (Krizhevsky et al., NIPS 2012) on smaller images: five convolutions, three
of them before a pooling, and three fully connected layers. It is trained from nothing: pretrained weights
are not to be had with this project, so the paper's transfer learning is left out.
"""

import torch
from torch import nn

PIXELS = 48
"""Along each side of the square around the unit sphere."""
CHANNELS = 6


def principal_views(points: torch.Tensor) -> torch.Tensor:
    """Pictures (B, 6, PIXELS, PIXELS) of clouds (B, N, 3) in their unit spheres."""
    turned = along_axes(points)
    return torch.cat([view(turned, axis) for axis in range(3)], dim=1)


def along_axes(points: torch.Tensor) -> torch.Tensor:
    """Coordinates (B, N, 3) along the principal axes, the longest last: it is z."""
    double = points.double()
    centered = double - double.mean(dim=1, keepdim=True)
    _, axes = torch.linalg.eigh(centered.transpose(1, 2) @ centered)
    turned = (double @ axes).float()
    return torch.where((turned**3).sum(dim=1, keepdim=True) < 0.0, -turned, turned)


def view(points: torch.Tensor, axis: int) -> torch.Tensor:
    """What is seen of points (B, N, 3) along an axis: counts and depths, (B, 2, PIXELS, PIXELS)."""
    count = len(points)
    across = torch.cat([points[..., :axis], points[..., axis + 1 :]], dim=2)
    places = ((across + 1.0) * (PIXELS / 2)).floor().long().clamp(0, PIXELS - 1)
    pixel = places[..., 0] * PIXELS + places[..., 1]
    empty = torch.zeros((count, PIXELS * PIXELS))
    held = empty.scatter_add(1, pixel, torch.ones_like(points[..., 0]))
    depth = empty.scatter_add(1, pixel, points[..., axis]) / held.clamp(min=1.0)
    bright = torch.log1p(held)
    bright = bright / bright.amax(dim=1, keepdim=True)
    return torch.stack([bright, depth], dim=1).view(count, 2, PIXELS, PIXELS)


def convolution(inputs: int, outputs: int, size: int) -> nn.Sequential:
    """With batch normalization, in the place of AlexNet's local one, and ReLU."""
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, size, padding=size // 2, bias=False),
        nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
    )


class AlexNet(nn.Module):
    """From pictures (B, 6, PIXELS, PIXELS) to numbers (B, outputs)."""

    def __init__(self, outputs: int, dropout: float = 0.5) -> None:
        super().__init__()
        self.seen = nn.Sequential(
            nn.Conv2d(CHANNELS, 24, 7, stride=2, padding=3, bias=False),
            nn.BatchNorm2d(24),
            nn.ReLU(inplace=True),
            nn.MaxPool2d(2),
            convolution(24, 64, 5),
            nn.MaxPool2d(2),
            convolution(64, 96, 3),
            convolution(96, 96, 3),
            convolution(96, 64, 3),
            nn.MaxPool2d(2),
        )
        self.whole = nn.Sequential(
            nn.Flatten(),
            nn.Dropout(dropout),
            nn.Linear(64 * 9, 256),
            nn.ReLU(inplace=True),
            nn.Dropout(dropout),
            nn.Linear(256, 256),
            nn.ReLU(inplace=True),
            nn.Linear(256, outputs),
        )

    def forward(self, pictures: torch.Tensor) -> torch.Tensor:
        numbers: torch.Tensor = self.whole(self.seen(pictures))
        return numbers
