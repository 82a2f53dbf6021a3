"""A small network on the features, trained elsewhere and served with NumPy alone."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .classifier import FeatureClassifier
from .features import N_FEATURES
from .rough import KINDS

Array = NDArray[np.float64]

CLIP = 5.0
"""Standardized features are held within this many standard deviations."""
LEAST = 1e-4
"""Probability that no kind falls below: none is ever impossible."""


class NetworkClassifier(FeatureClassifier):
    """Fully connected layers with ReLU between them; `sha256` names the weights.

    Parameters
    ----------
    arrays : `mean`, `scale` (N_FEATURES,), `weight0`, `bias0`, `weight1`, ... of the layers, weights as
        (outputs, inputs), and `temperature` (1,), by which logits are divided
    sha256 : of the weights
    """

    NAME = "network"

    def __init__(self, arrays: Mapping[str, NDArray[Any]], sha256: str = "") -> None:
        super().__init__(arrays, sha256)
        wide = {name: np.asarray(values, np.float64) for name, values in arrays.items()}
        self.mean, self.scale = wide["mean"], wide["scale"]
        self.temperature = float(wide["temperature"][0])
        depth = sum(name.startswith("weight") for name in wide)
        self.layers = [(wide[f"weight{k}"].T.copy(), wide[f"bias{k}"]) for k in range(depth)]
        sizes = [N_FEATURES, *(len(bias) for _, bias in self.layers)]
        if sizes[-1] != len(KINDS) or self.mean.shape != (N_FEATURES,) or self.scale.shape != (N_FEATURES,):
            raise ValueError(f"{N_FEATURES} features and {len(KINDS)} kinds are needed")
        for (weight, _), shape in zip(self.layers, pairwise(sizes), strict=True):
            if weight.shape != shape:
                raise ValueError(f"a layer of weights {shape} is needed, not {weight.shape}")
        if not self.temperature > 0.0:
            raise ValueError(f"the temperature must be positive, not {self.temperature}")

    def logits(self, rows: Array) -> Array:
        """(M, N_FEATURES) -> (M, 5), before the temperature."""
        values = np.clip((rows - self.mean) / self.scale, -CLIP, CLIP)
        for weight, bias in self.layers[:-1]:
            values = np.maximum(values @ weight + bias, 0.0)
        weight, bias = self.layers[-1]
        return values @ weight + bias

    def probabilities(self, rows: Array) -> Array:
        """(M, N_FEATURES) -> (M, 5), after the temperature (Guo et al., "On calibration", ICML 2017)."""
        return LEAST + (1.0 - len(KINDS) * LEAST) * softmax(self.logits(rows) / self.temperature)


def softmax(logits: Array) -> Array:
    """Along the last axis."""
    powers = np.exp(logits - logits.max(axis=-1, keepdims=True))
    return powers / powers.sum(axis=-1, keepdims=True)
