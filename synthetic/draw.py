"""Any recipe's clouds: cloud `i` of a recipe depends on the recipe and on `i` only."""

from collections.abc import Iterator

from .clouds import SyntheticCloud
from .foreign import foreign_cloud
from .recipes import BenchmarkRecipe, ForeignRecipe, Recipe, SensorRecipe
from .scanner import scanner_cloud
from .sensing import sensor_cloud
from .shrec import benchmark_cloud


def cloud(recipe: Recipe, index: int) -> SyntheticCloud:
    """Cloud `index` of a recipe, whatever was drawn before it."""
    if isinstance(recipe, BenchmarkRecipe):
        return benchmark_cloud(recipe, index)
    if isinstance(recipe, ForeignRecipe):
        return foreign_cloud(recipe, index)
    if isinstance(recipe, SensorRecipe):
        return sensor_cloud(recipe, index)
    return scanner_cloud(recipe, index)


def clouds(recipe: Recipe, n: int, start: int = 0) -> Iterator[SyntheticCloud]:
    """Clouds start .. start + n - 1 of a recipe."""
    return (cloud(recipe, index) for index in range(start, start + n))
