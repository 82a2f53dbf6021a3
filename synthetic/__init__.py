"""Labelled point clouds on demand, like those of the SHREC 2022 benchmark."""

from synthetic.clouds import SyntheticCloud
from synthetic.recipes import PERTURBATIONS, BenchmarkRecipe
from synthetic.shrec import batch, sample_cloud
from synthetic.shrec import benchmark_cloud as cloud

__all__ = ["PERTURBATIONS", "BenchmarkRecipe", "SyntheticCloud", "batch", "cloud", "sample_cloud"]
