"""Trained networks on disk: as `models.weights` stores arrays, in half precision where they were learned."""

from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from primfit.models.weights import load

from ..method import DIRECTORY as DIRECTORY
from .pointnet import PointNet, Widths
from .views import AlexNet
from .voxels import VoxelNet


def arrays_of(network: nn.Module) -> dict[str, NDArray[Any]]:
    """What a network has learned, as float16, and its running means and variances, as float32."""
    learned = {name: value.detach().numpy().astype(np.float16) for name, value in network.named_parameters()}
    running = {
        name: value.numpy().astype(np.float32)
        for name, value in network.named_buffers()
        if value.is_floating_point()
    }
    return {**learned, **running}


def built(network: dict[str, Any]) -> nn.Module:
    """The network that a recipe describes, not trained."""
    outputs, dropout = network["outputs"], network["dropout"]
    match network["design"]:
        case "pointnet":
            widths = Widths(**{name: tuple(sizes) for name, sizes in network["widths"].items()})
            return PointNet(outputs, widths, dropout)
        case "voxels":
            return VoxelNet(outputs, dropout)
        case "views":
            return AlexNet(outputs, dropout)
    raise ValueError(f"there is no network {network['design']!r}")


def filled(network: nn.Module, arrays: dict[str, NDArray[Any]]) -> nn.Module:
    """The network with these arrays, ready to be asked."""
    state = {name: torch.from_numpy(values.astype(np.float32)) for name, values in arrays.items()}
    network.load_state_dict(state, strict=False)
    missing = {*arrays_of(network)} ^ {*arrays}
    if missing:
        raise ValueError(f"the weights differ from the network in {', '.join(sorted(missing))}")
    return network.eval()


def restored(name: str, directory: Path = DIRECTORY) -> nn.Module:
    """The trained network of that name.

    Raises
    ------
    primfit.models.weights.WeightsMismatchError : its weights are not there, or not those of this code
    """
    arrays, card = load(name, directory)
    return filled(built(card.recipe["network"]), arrays)
