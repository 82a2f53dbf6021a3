"""Labelled point clouds on demand: like those of the SHREC 2022 benchmark, of a virtual scanner, of
named sensors, of foreign shapes."""

from .clouds import SyntheticCloud
from .draw import cloud, clouds
from .recipes import (
    PERTURBATIONS,
    RECIPES,
    BenchmarkRecipe,
    ForeignRecipe,
    Recipe,
    ScannerRecipe,
    SensorRecipe,
)
from .shrec import batch, sample_cloud

__all__ = [
    "PERTURBATIONS",
    "RECIPES",
    "BenchmarkRecipe",
    "ForeignRecipe",
    "Recipe",
    "ScannerRecipe",
    "SensorRecipe",
    "SyntheticCloud",
    "batch",
    "cloud",
    "clouds",
    "sample_cloud",
]
