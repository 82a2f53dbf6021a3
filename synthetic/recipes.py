"""The recipes: frozen, seeded descriptions of families of clouds, and the dict that names them.

The benchmark's numbers describe the training set of SHREC 2022 (Romanengo et al., Computers & Graphics
107, 2022, section 2.1). What the paper does not say was read off the published truth of the 46,000 training
clouds, which lie in blocks of one perturbation type: radii, angles, axes, positions and numbers of points,
with the sizes of cylinders, cones and planes inferred from how far they are moved (a translation is at most
three times the half-extent). No points of any cloud were used.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Range:
    """The uniform distribution on [low, high]; lengths carry the unit of the cloud, angles are radians."""

    low: float
    high: float

    def __post_init__(self) -> None:
        if not self.low <= self.high:
            raise ValueError(f"a range needs low <= high, not [{self.low}, {self.high}]")


@dataclass(frozen=True)
class NoiseLaw:
    """The values of n in U(-1/n, 1/n) and in N(-1/n, (2/n)^2); one is drawn a cloud."""

    uniform_n: tuple[int, ...] = (3, 5, 10, 15, 20)
    gaussian_n: tuple[int, ...] = (10, 15, 20, 25, 30)


KINDS = ("plane", "sphere", "cylinder", "cone", "torus")
"""Kinds that clouds are drawn of; there may be others."""

PERTURBATIONS = ("A0", "A1", "A2", "A3", "A4", "A5", "A6", "A7", "A8", "A9")
TRAINING_COUNTS = (5000,) * 9 + (1000,)
"""Clouds of each perturbation type in the benchmark's training set: their shares in a batch."""


FEWEST = 10
"""Points of a cloud, at least."""


def _check(seed: int, **choices: tuple[tuple[str, ...], tuple[str, ...]]) -> None:
    for name, (given, known) in choices.items():
        if not given or not set(given) <= set(known):
            raise ValueError(f"{name} must be some of {known}, not {given}")
    if seed < 0:
        raise ValueError(f"seed must not be negative, not {seed}")


def _check_points(points: Range) -> None:
    if points.low < FEWEST:
        raise ValueError(f"points must be at least {FEWEST}, not {points.low}")


def _check_outliers(outliers: Range) -> None:
    if not 0.0 <= outliers.low <= outliers.high < 1.0:
        raise ValueError(f"outliers must be shares below 1, not {outliers}")


@dataclass(frozen=True)
class BenchmarkRecipe:
    """Benchmark-like clouds: cloud `i` depends on `seed` and `i` alone.

    Kinds take turns, so any run of len(kinds) clouds is balanced. The perturbation type is drawn with the
    frequencies of the benchmark's training set, restricted to `perturbations`.
    """

    seed: int
    kinds: tuple[str, ...] = KINDS
    perturbations: tuple[str, ...] = PERTURBATIONS

    def __post_init__(self) -> None:
        _check(self.seed, kinds=(self.kinds, KINDS), perturbations=(self.perturbations, PERTURBATIONS))


@dataclass(frozen=True)
class ScannerRecipe:
    """Clouds of a virtual scanner (`synthetic.scanner`): cloud `i` depends on `seed` and `i` alone.

    Attributes
    ----------
    kinds : they take turns
    points : number of points, log-uniform
    noise : standard deviation along the ray as a share of the extent (the diagonal of the surface seen),
        log-uniform; none at all in a share `noiseless` of the clouds
    outliers : share of gross outliers, uniform; none at all in a share `without_outliers` of the clouds
    arc : degrees of azimuth of the object (of a sphere: of its cap), log-uniform; all 360 in a share `whole`
    half_angle : of cones [deg], log-uniform
    torus_ratio : major over minor radius, log-uniform
    slenderness : length of a cylinder over its radius, log-uniform
    size : extent of the surface seen [m], log-uniform
    stations : the largest number of stations; one to so many are drawn
    decidable : lower the noise where it would hide what tells the kind from a simpler one
    """

    seed: int = 0
    kinds: tuple[str, ...] = KINDS
    points: Range = Range(20, 20_000)
    noise: Range = Range(1e-4, 0.02)
    noiseless: float = 0.05
    outliers: Range = Range(0.0, 0.2)
    without_outliers: float = 0.4
    arc: Range = Range(30.0, 360.0)
    whole: float = 0.4
    half_angle: Range = Range(2.0, 80.0)
    torus_ratio: Range = Range(1.1, 20.0)
    slenderness: Range = Range(0.3, 15.0)
    size: Range = Range(5e-4, 10.0)
    stations: int = 4
    decidable: bool = True

    def __post_init__(self) -> None:
        _check(self.seed, kinds=(self.kinds, KINDS))
        _check_points(self.points)
        _check_outliers(self.outliers)
        if not 0.0 < self.arc.low <= self.arc.high <= 360.0:
            raise ValueError(f"arc must lie within 0 and 360 degrees, not {self.arc}")


SHAPES = ("ellipsoid", "corner", "capped_cylinder", "saddle", "blob", "two_primitives")


@dataclass(frozen=True)
class ForeignRecipe:
    """Clouds of shapes that are none of the five kinds (`synthetic.foreign`); `shapes` take turns."""

    seed: int = 0
    shapes: tuple[str, ...] = SHAPES
    points: Range = Range(200, 10_000)
    noise: Range = Range(1e-4, 0.01)
    outliers: Range = Range(0.0, 0.1)
    without_outliers: float = 0.5
    size: Range = Range(5e-4, 10.0)

    def __post_init__(self) -> None:
        _check(self.seed, shapes=(self.shapes, SHAPES))
        _check_points(self.points)


SENSORS = (
    "structured light",
    "stereo",
    "time of flight",
    "phone",
    "spinning",
    "terrestrial",
    "laser line",
    "fringe",
    "photogrammetry",
    "fused mesh",
    "contact",
)


@dataclass(frozen=True)
class SensorRecipe:
    """Clouds of named sensors (`synthetic.sensing`): cloud `i` depends on `seed` and `i` alone.

    Attributes
    ----------
    kinds : they take turns
    sensors : drawn with equal chances, until one sees a part of the kind so that it can be told
    points : number of points, log-uniform
    many, share_of_many : the same, of a few larger clouds, and how many these are
    outliers : share of gross outliers, uniform; none at all in a share `without_outliers` of the clouds
    """

    seed: int = 0
    kinds: tuple[str, ...] = KINDS
    sensors: tuple[str, ...] = SENSORS
    points: Range = Range(50, 20_000)
    many: Range = Range(20_000, 200_000)
    share_of_many: float = 0.05
    outliers: Range = Range(0.0, 0.03)
    without_outliers: float = 0.6

    def __post_init__(self) -> None:
        _check(self.seed, kinds=(self.kinds, KINDS), sensors=(self.sensors, SENSORS))
        _check_points(self.points)
        _check_outliers(self.outliers)


Recipe = BenchmarkRecipe | ScannerRecipe | SensorRecipe | ForeignRecipe

RECIPES: dict[str, Recipe] = {
    "benchmark": BenchmarkRecipe(seed=0),
    "scanner": ScannerRecipe(),
    "scanner-hard": ScannerRecipe(
        noise=Range(1e-3, 0.05),
        noiseless=0.0,
        outliers=Range(0.0, 0.6),
        without_outliers=0.1,
        arc=Range(10.0, 360.0),
        whole=0.2,
        decidable=False,
    ),
    "scanner-large": ScannerRecipe(points=Range(20_000, 1_000_000)),
    "sensor": SensorRecipe(),
    "foreign": ForeignRecipe(),
}
"""By name; `dataclasses.replace(RECIPES[name], seed=...)` draws other clouds of the same laws."""
