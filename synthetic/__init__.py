"""Labelled point clouds on demand, like those of the SHREC 2022 benchmark."""

from synthetic.recipes import PERTURBATIONS, BenchmarkRecipe
from synthetic.shrec import SyntheticCloud, batch, cloud, sample_cloud

__all__ = ["PERTURBATIONS", "BenchmarkRecipe", "SyntheticCloud", "batch", "cloud", "sample_cloud"]
