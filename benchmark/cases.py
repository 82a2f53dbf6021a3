"""Labelled clouds to measure on: the sets by name, and any folder in the layout of the SHREC 2022 track.

Cloud `i` of a set depends on the seed and `i` only, and levels and kinds take turns, so that the first n
clouds of a set are as balanced as all of them. Sets of levels show each piece at every level: only the level
changes.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from typing import TypeVar

import numpy as np

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.primitive import Primitive
from primfit.synthetic import RECIPES, BenchmarkRecipe, ForeignRecipe, ScannerRecipe, SyntheticCloud, cloud
from primfit.synthetic.bows import DEVIATIONS, DEVIATIONS_OF
from primfit.synthetic.clouds import MOVES
from primfit.synthetic.foreign import cloud_and_shape
from primfit.synthetic.noise import rounded
from primfit.synthetic.perturb import random_subset, uniform_noise
from primfit.synthetic.recipes import KINDS, PERTURBATIONS, SENSORS, SHAPES, Range
from primfit.synthetic.sections import SECTIONS

from . import bows, cone_arcs, prisms
from .measures import diagonal
from .nearest import off_every_kind
from .pieces import BOW, CLEAR, GAINS, NOISE_LAWS, PAIRS_OF, pair_cloud, round_cloud

Level = str | float
L = TypeVar("L")


@dataclass(frozen=True, eq=False)
class Case:
    """One cloud with its truth.

    Attributes
    ----------
    name : within its set
    points : (N, 3)
    truth : None for a foreign shape, of which no answer is right, and where only the kind is known
    groups : what results are grouped by besides the kind
    outliers : mask (N,) of points that do not belong to the surface, None where they are not known
    noise : standard deviation of the others, None where there is no single one
    known_kind : the true kind where no parameters are known
    """

    name: str
    points: Array
    truth: Primitive | None
    groups: Mapping[str, Level]
    outliers: np.ndarray | None = None
    noise: float | None = None
    known_kind: str | None = None

    @property
    def kind(self) -> str:
        """The true one; `foreign` where no kind is right."""
        return self.truth.kind if self.truth else self.known_kind or "foreign"

    @property
    def surface_points(self) -> Array:
        """The points that belong to the surface."""
        return self.points if self.outliers is None else self.points[~self.outliers]


@dataclass(frozen=True)
class Description:
    """What the report says of a set; `groups` holds their levels in the order in which they are shown."""

    title: str
    about: str
    groups: Mapping[str, tuple[Level, ...]]


@dataclass(frozen=True)
class CaseSet:
    """A family of cases: case `i` of a seed is draw(seed, i); small and full runs take so many.

    Of an `own` one, which is there for a bar that primfit is held to, methods of others are not asked.
    """

    description: Description
    small: int
    full: int
    draw: Callable[[int, int], Case]
    own: bool = False


# -- the benchmark ------------------------------------------------------------------------------------------

TEST_SET = (*PERTURBATIONS[:9] * 4, PERTURBATIONS[9])
"""Perturbations in the proportions of the track's test set: 100 clouds of A0 to A8 each, 25 of A9."""


Buckets = tuple[tuple[float, str], ...]
"""Upper bounds and names."""

TRACK_POINTS: Buckets = ((500, "up to 500"), (2000, "500 to 2,000"), (np.inf, "over 2,000"))


def bucket(bounds: Buckets, value: float) -> str:
    return next(name for bound, name in bounds if value <= bound)


def shrec(seed: int, index: int) -> Case:
    kind, _, perturbation = turn(index, KINDS, TEST_SET)
    drawn = cloud(BenchmarkRecipe(seed, (kind,), (perturbation,)), index)
    return case(index, drawn, track_groups(perturbation, len(drawn.points)))


def track_groups(perturbation: str, points: int) -> dict[str, Level]:
    return {"perturbation": perturbation, "points": bucket(TRACK_POINTS, points)}


EXACT = (2, 5, 10, 20, 30, 50, 75, 100)
EXACT_NOISE = 10
"""The n of the noise U(-1/n, 1/n) of the points that are not exact."""


def exact_share(seed: int, index: int) -> Case:
    kind, piece, level = turn(index, KINDS, EXACT)
    drawn = cloud(BenchmarkRecipe(seed, (kind,), ("A0",)), piece)
    rng = np.random.default_rng([seed, piece, 3])
    points = drawn.points.copy()
    moved = random_subset(rng, len(points), len(points) - round(level / 100 * len(points)))
    points[moved] += uniform_noise(rng, int(np.count_nonzero(moved)), EXACT_NOISE)
    return case(index, replace(drawn, points=points), {"exact [%]": level})


# -- scans --------------------------------------------------------------------------------------------------

SCAN_BUCKETS: dict[str, Buckets] = {
    "points": ((100, "20 to 100"), (1000, "100 to 1,000"), (np.inf, "1,000 to 20,000")),
    "noise": ((0.0, "none"), (1e-3, "up to 0.1%"), (5e-3, "0.1 to 0.5%"), (np.inf, "0.5 to 2%")),
    "outliers": ((0.0, "none"), (0.1, "up to 10%"), (np.inf, "over 10%")),
}
"""Noise is a share of the extent."""


def scanner(seed: int, index: int) -> Case:
    drawn = cloud(replace(RECIPES["scanner"], seed=seed), index)
    assert drawn.noise is not None and drawn.extent is not None
    seen = {
        "points": len(drawn.points),
        "noise": drawn.noise / drawn.extent,
        "outliers": drawn.outlier_share,
    }
    return case(index, drawn, {name: bucket(SCAN_BUCKETS[name], value) for name, value in seen.items()})


SENSOR_POINTS: Buckets = (
    (200, "50 to 200"),
    (1000, "200 to 1,000"),
    (5000, "1,000 to 5,000"),
    (20_000, "5,000 to 20,000"),
    (np.inf, "over 20,000"),
)


def sensor(seed: int, index: int) -> Case:
    drawn = cloud(replace(RECIPES["sensor"], seed=seed), index)
    points = bucket(SENSOR_POINTS, len(drawn.points))
    seen = {"points": points, "sensor": drawn.sensor, "largest effect": drawn.largest_effect}
    return case(index, drawn, seen)


SCAN = ScannerRecipe(points=Range(2000, 2000), noise=Range(1e-3, 1e-3), noiseless=0.0, without_outliers=1.0)
"""What these sets have in common: 2,000 points, noise of a thousandth of the extent, no gross outliers."""

OUTLIERS = (0, 10, 20, 30, 40, 50, 60)


def outliers(seed: int, index: int) -> Case:
    kind, piece, level = turn(index, KINDS, OUTLIERS)
    share = Range(level / 100, level / 100)
    recipe = replace(SCAN, seed=seed, kinds=(kind,), outliers=share, without_outliers=0.0)
    return case(index, cloud(recipe, piece), {"outliers [%]": level})


SHORTEST_ARC = 60.0
HELD_ARCS: Buckets = ((120.0, "60 to 120"), (240.0, "120 to 240"), (np.inf, "240 to 360"))
NEIGHBOURS = ("independent", "correlated")
REDRAWN = 1_000_000
"""Clouds that are not as they should be are drawn again with an index that is larger by this."""


def scans(noise: float, seed: int, index: int) -> Case:
    """With this noise, a share of the extent, neither more nor less.

    The recipe lowers noise that would hide the kind; such clouds are drawn again, arc and all.
    """
    for other in count(index, REDRAWN):
        arc = np.random.default_rng([seed, other, 4]).uniform(SHORTEST_ARC, 360.0)
        recipe = replace(SCAN, seed=seed, kinds=(KINDS[index % len(KINDS)],), noise=Range(noise, noise))
        drawn = cloud(replace(recipe, arc=Range(arc, arc), whole=0.0), other)
        assert drawn.noise is not None and drawn.extent is not None
        if np.isclose(drawn.noise, noise * drawn.extent):
            break
    neighbours = NEIGHBOURS[1 if drawn.correlation else 0]
    return case(index, drawn, {"arc [deg]": bucket(HELD_ARCS, arc), "neighbours": neighbours})


ARCS = (360, 180, 90, 60, 30, 20, 10)


def arcs(seed: int, index: int) -> Case:
    kind, piece, level = turn(index, KINDS[1:], ARCS)
    recipe = replace(SCAN, seed=seed, kinds=(kind,), arc=Range(level, level), whole=0.0)
    return case(index, cloud(recipe, piece), {"arc [deg]": level})


NEAR: dict[str, ScannerRecipe] = {
    "cone of 1 degree": replace(SCAN, kinds=("cone",), half_angle=Range(1.0, 1.0)),
    "torus with R = 20 r": replace(SCAN, kinds=("torus",), torus_ratio=Range(20.0, 20.0)),
    "cylinder": replace(SCAN, kinds=("cylinder",)),
    "sphere cap of 5 degrees": replace(SCAN, kinds=("sphere",), arc=Range(5.0, 5.0), whole=0.0),
    "huge sphere, cap of 1 degree": replace(SCAN, kinds=("sphere",), arc=Range(1.0, 1.0), whole=0.0),
    "plane": replace(SCAN, kinds=("plane",)),
}
"""Each beside the simpler kind that it nearly is."""
NEAR_NOISE = ("none", "what hides nothing")


def near_degenerate(seed: int, index: int) -> Case:
    shape, piece, noise = turn(index, tuple(NEAR), NEAR_NOISE)
    recipe = replace(NEAR[shape], seed=seed, noiseless=1.0 if noise == "none" else 0.0)
    return case(index, cloud(recipe, piece), {"shape": shape, "noise": noise})


SIZES = (20, 50, 100, 300, 1000, 10_000, 100_000, 1_000_000)


def sizes(seed: int, index: int) -> Case:
    """Recipes add points to clouds that are too small for their kind; those are left out again."""
    kind, piece, level = turn(index, KINDS, SIZES)
    drawn = cloud(replace(SCAN, seed=seed, kinds=(kind,), points=Range(level, level)), piece)
    assert drawn.outliers is not None
    drawn = replace(drawn, points=drawn.points[:level], outliers=drawn.outliers[:level])
    return case(index, drawn, {"points": level})


# -- both ---------------------------------------------------------------------------------------------------

FAMILIES: dict[str, BenchmarkRecipe | ScannerRecipe] = {
    "benchmark": BenchmarkRecipe(0, perturbations=PERTURBATIONS[:3]),
    "scanner": replace(SCAN, size=Range(1.0, 1.0)),
}
COORDINATES = ("as they are", "float32", "1 mm", "offset 1e7")
OFFSET = np.array([1e7, -1e7, 1e7])
MILLIMETRE = 1e-3
"""Of an object of a meter, and of a benchmark cloud as if its unit were the meter."""


def coordinates(seed: int, index: int) -> Case:
    """The same clouds, near the origin, after what files and maps do to coordinates.

    Clouds whose file is rounded already are drawn again.
    """
    kind, other, level = turn(index, KINDS, COORDINATES)
    family = tuple(FAMILIES)[other // len(KINDS) % len(FAMILIES)]
    drawn = cloud(replace(FAMILIES[family], seed=seed, kinds=(kind,)), other)
    while drawn.step:
        other += REDRAWN
        drawn = cloud(replace(FAMILIES[family], seed=seed, kinds=(kind,)), other)
    shift = (OFFSET if level == "offset 1e7" else 0.0) - drawn.points.mean(axis=0)
    points = drawn.points + shift
    if level == "float32":
        points, _ = rounded(points, None)
    elif level == "1 mm":
        points, _ = rounded(points, MILLIMETRE * (drawn.extent or 1.0))
    assert drawn.primitive is not None
    moved = replace(drawn, points=points, primitive=drawn.primitive.transformed(np.eye(3), shift, 1.0))
    return case(index, moved, {"coordinates": level, "family": family})


# -- pieces whose noise is known ----------------------------------------------------------------------------

PAIR_GROUPS = {
    pair + (", clear" if level == CLEAR else ""): (pair, level) for level in GAINS for pair in PAIRS_OF[level]
}
"""The pair and the level of each group."""


def ambiguity(seed: int, index: int) -> Case:
    """Both surfaces of each pair in turn: those that nobody can tell, then the clear ones."""
    group = tuple(PAIR_GROUPS)[index // 2 % len(PAIR_GROUPS)]
    pair, level = PAIR_GROUPS[group]
    drawn = pair_cloud(np.random.default_rng([seed, index, 5]), pair, index % 2 == 0, level)
    return case(index, drawn, {"the pair is": level, "pair": group})


ROUND = ("sphere", "cylinder")
OBJECTS = {"whole": 360.0, "of 120 degrees": 120.0}


def bias(seed: int, index: int) -> Case:
    kind, piece, level = turn(index, ROUND, tuple((law, shape) for law in NOISE_LAWS for shape in OBJECTS))
    law, shape = level
    drawn = round_cloud(np.random.default_rng([seed, piece, 6]), kind, OBJECTS[shape], law)
    return case(index, drawn, {"noise": law, "object": shape})


# -- parts that deviate from their kind ---------------------------------------------------------------------

AMPLITUDES = (0.25, 0.5, 1.0, 3.0)
SLIGHT = AMPLITUDES[:3]
"""Multiples of the noise up to which the true kind is right, whatever the number of points."""
BOW_BUCKETS: dict[str, Buckets] = {
    "points": ((1000, "200 to 1,000"), (10_000, "1,000 to 10,000"), (np.inf, "10,000 to 50,000")),
    "noise": ((1e-3, "up to 0.1%"), (np.inf, "0.1 to 0.5%")),
}


def bowed(seed: int, index: int) -> Case:
    kind, piece, level = turn(index, KINDS, AMPLITUDES)
    deviations = DEVIATIONS_OF[kind]
    deviation = deviations[piece // len(KINDS) % len(deviations)]
    drawn = bows.bowed_cloud(np.random.default_rng([seed, piece, 9]), kind, deviation, level)
    assert drawn.noise is not None and drawn.extent is not None
    seen = {"points": len(drawn.points), "noise": drawn.noise / drawn.extent}
    groups = {name: bucket(BOW_BUCKETS[name], value) for name, value in seen.items()}
    return case(index, drawn, {"amplitude [noise]": level, "deviation": deviation, **groups})


CONE_ARCS = ("cone", "cylinder")
ANGLE_BUCKETS: Buckets = ((50.0, "20 to 50"), (200.0, "50 to 200"), (np.inf, "over 200"))
CONE_ARC_POINTS: Buckets = ((1000, "300 to 1,000"), (5000, "1,000 to 5,000"), (np.inf, "5,000 to 20,000"))


def cone_arc(seed: int, index: int) -> Case:
    """Cone and cylinder take turns on the same arc, with the same noise."""
    _, arc, shape = turn(index, ("cone arc",), CONE_ARCS)
    drawn, shown = cone_arcs.arc_cloud(np.random.default_rng([seed, arc, 10]), shape)
    points = bucket(CONE_ARC_POINTS, len(drawn.points))
    return case(
        index, drawn, {"shape": shape, "chi^2 of the angle": bucket(ANGLE_BUCKETS, shown), "points": points}
    )


PIPE = "pipe"
ONE_PIPE_IN = 4
DEVIATIONS_SEEN: Buckets = ((1.0, "under 1"), (3.0, "1 to 3"), (np.inf, "over 3"))
"""Of a section from the nearest circle or line, or of a foreign shape from the nearest primitive, in noise
scales (root mean square)."""
FAR_OFF = DEVIATIONS_SEEN[-1][1]


def sections(seed: int, index: int) -> Case:
    """Every fourth cloud is a pipe; between them sorts take turns."""
    rounds, place = divmod(index, ONE_PIPE_IN)
    rng = np.random.default_rng([seed, index, 11])
    if place == ONE_PIPE_IN - 1:
        return case(index, prisms.pipe_cloud(rng), {"deviation": PIPE, "section": PIPE})
    sorts = tuple(SECTIONS)
    sort = sorts[(rounds * (ONE_PIPE_IN - 1) + place) % len(sorts)]
    drawn, deviation = prisms.section_cloud(rng, sort)
    return case(index, drawn, {"deviation": bucket(DEVIATIONS_SEEN, deviation), "section": sort})


def foreign(seed: int, index: int) -> Case:
    drawn, shape = cloud_and_shape(ForeignRecipe(seed), index)
    assert drawn.noise is not None and drawn.extent is not None
    deviation = off_every_kind(shape) / diagonal(shape) / max(drawn.noise / drawn.extent, BOW)
    return case(index, drawn, {"deviation": bucket(DEVIATIONS_SEEN, deviation), "shape": drawn.kind})


# -- all ----------------------------------------------------------------------------------------------------


def turn(index: int, kinds: tuple[str, ...], levels: tuple[L, ...]) -> tuple[str, int, L]:
    """Kinds take turns, then levels: the kind, the number of the piece that is shown, and the level."""
    rounds, level = divmod(index // len(kinds), len(levels))
    kind = index % len(kinds)
    return kinds[kind], rounds * len(kinds) + kind, levels[level]


def case(index: int, drawn: SyntheticCloud, groups: Mapping[str, Level]) -> Case:
    return Case(str(index), drawn.points, drawn.primitive, groups, drawn.outliers, drawn.noise)


def _names(bounds: Buckets) -> tuple[str, ...]:
    return tuple(name for _, name in bounds)


def _scans_of(noise: float) -> Description:
    return Description(
        f"Scans with noise of {noise:g}%",
        f"Scans of 2,000 points with noise of {noise:g}% of the extent, no gross outliers (mixed pixels at "
        "edges come with scans), arcs uniform from 60 degrees to a whole turn. The noise is never lowered: "
        "where it would hide the kind from the simpler ones, piece and arc are drawn again. So slender and "
        "flat pieces are missing, and at 2% cones of short arcs.",
        {"arc [deg]": _names(HELD_ARCS), "neighbours": NEIGHBOURS},
    )


CASE_SETS: dict[str, CaseSet] = {
    "shrec": CaseSet(
        Description(
            "Clouds like those of SHREC 2022",
            "The paper's ten perturbations in the proportions of its test set (100 clouds of A0 to A8 each, "
            "25 of A9, kinds balanced). Only some of a cloud's points are perturbed; the others lie on the "
            "surface to the last digit.",
            {"perturbation": PERTURBATIONS, "points": _names(TRACK_POINTS)},
        ),
        185,
        925,
        shrec,
    ),
    "sensor": CaseSet(
        Description(
            "Sensors",
            "Parts as eleven sorts of sensors see them, from depth cameras to contact machines: noise that "
            "is mostly correlated, depth steps, rings, waves along lines, bows of the sensor and of the "
            "part, double walls, fringes and tails at edges, ragged borders, up to 3% gross outliers; 50 to "
            "200,000 points. Whoever knew the errors' covariance could tell the kind.",
            {"points": _names(SENSOR_POINTS), "sensor": SENSORS, "largest effect": MOVES},
        ),
        150,
        500,
        sensor,
    ),
    "scanner": CaseSet(
        Description(
            "Scans",
            "What one to four stations of a virtual scanner see of a piece: every point noisy (up to 2% of "
            "the extent, less where that would hide the kind), up to 20% gross outliers, arcs from 30 "
            "degrees, 20 to 20,000 points.",
            {name: _names(bounds) for name, bounds in SCAN_BUCKETS.items()},
        ),
        150,
        1000,
        scanner,
    ),
    "scans-0.3": CaseSet(
        _scans_of(0.3),
        40,
        500,
        partial(scans, 0.003),
    ),
    "scans-2": CaseSet(
        _scans_of(2),
        40,
        500,
        partial(scans, 0.02),
    ),
    "outliers": CaseSet(
        Description(
            "Gross outliers",
            "Scans of 2,000 points with noise of 0.1% of the extent, of which a share has nothing to do "
            "with the surface.",
            {"outliers [%]": OUTLIERS},
        ),
        70,
        350,
        outliers,
    ),
    "arcs": CaseSet(
        Description(
            "Arcs",
            "Scans of an object that is a part of a turn (of a sphere: a cap); of a whole turn a scanner "
            "may see half. Noise of 0.1% of the extent, less where that would hide the kind. Planes have "
            "no arc.",
            {"arc [deg]": ARCS},
        ),
        56,
        280,
        arcs,
    ),
    "near-degenerate": CaseSet(
        Description(
            "Nearly another kind",
            "Scans of shapes that are nearly a simpler kind, and of those kinds; the noise is low enough to "
            "tell.",
            {"shape": tuple(NEAR), "noise": NEAR_NOISE},
        ),
        36,
        240,
        near_degenerate,
    ),
    "exact-share": CaseSet(
        Description(
            "Share of exact points",
            "Clouds of the benchmark with noise U(-0.1, 0.1) on all but a share of the points.",
            {"exact [%]": EXACT},
        ),
        40,
        400,
        exact_share,
    ),
    "sizes": CaseSet(
        Description(
            "Number of points",
            "Scans with noise of 0.1% of the extent and no gross outliers, from 20 points to a million.",
            {"points": SIZES},
        ),
        40,
        80,
        sizes,
    ),
    "coordinates": CaseSet(
        Description(
            "Coordinates",
            "The same clouds with coordinates as they are, as float32, in steps of a millimeter (objects of "
            "a metre), and with 1e7 added.",
            {"coordinates": COORDINATES, "family": tuple(FAMILIES)},
        ),
        40,
        400,
        coordinates,
    ),
    "ambiguity": CaseSet(
        Description(
            "What cannot be told, and what can",
            "Pairs of surfaces of different kinds that hardly differ where the cloud is: 30 to 60 points on "
            "one of the two, with independent normal noise along the normal. *Indistinguishable*: with so "
            "much noise (1 to 2% of the extent) that the truth gains only 0.1 in log-likelihood on the "
            "other surface, on the average; whoever knew the noise and both surfaces would be right on 59 %. "
            "The right answer is the simpler kind, whichever was drawn; one that is `ambiguous` and names it "
            "first is as good for the bar, but not counted as right here. *Clearly distinguishable*: pairs "
            "that are over 0.6% of the extent apart (root mean square), three times what sensors and parts "
            "bow by, with so little noise that the gain is 500. The true kind is right. No surface has a "
            "radius of over 5 extents, no torus meets itself.",
            {"the pair is": tuple(GAINS), "pair": tuple(PAIR_GROUPS)},
        ),
        100,
        960,
        ambiguity,
    ),
    "bias": CaseSet(
        Description(
            "Bias of the radius",
            "Spheres and cylinders (two radii long), whole and of 120 degrees, sampled evenly: 1,000 points "
            "with independent normal noise of 1% of the radius, along the normal or the same in all "
            "directions.",
            {"noise": NOISE_LAWS, "object": tuple(OBJECTS)},
        ),
        160,
        2000,
        bias,
        own=True,
    ),
    "bows": CaseSet(
        Description(
            "Bows, lobes and barrels",
            "Parts that deviate smoothly from their kind by 0.25 to 3 noise scales (root mean square, what "
            "the parameters of the kind cannot take): planes with a dome or a sag, cylinders, cones and "
            "tori that are bent, have two to five lobes or bulge, spheres with lobes or a bulge; sign and "
            "direction at random. White noise of 0.02 to 0.5% of the extent along the normal, 200 to "
            "50,000 points (log-uniform). Each part is shown at every amplitude. The right answer is the "
            "kind of the part; at 3 noise scales a more general kind that follows the deviation, or "
            "`ambiguous`, will do.",
            {
                "amplitude [noise]": AMPLITUDES,
                "points": _names(BOW_BUCKETS["points"]),
                "deviation": tuple(DEVIATIONS),
                "noise": _names(BOW_BUCKETS["noise"]),
            },
        ),
        120,
        1200,
        bowed,
        own=True,
    ),
    "cone-arcs": CaseSet(
        Description(
            "Short arcs of cones",
            "Cones of 20 to 60 degrees on arcs of 30 to 60 degrees whose radius doubles, 300 to 20,000 "
            "points with independent noise, under which the points show the angle: twice what the best cone "
            "gains on the best cylinder in log-likelihood, the chi^2 of the angle, is over 20 (drawn "
            "log-uniform up to 500; noise of at most 3% of the extent). And cylinders of the same radius, "
            "arc and length, with as many points and as much noise.",
            {
                "shape": CONE_ARCS,
                "chi^2 of the angle": _names(ANGLE_BUCKETS),
                "points": _names(CONE_ARC_POINTS),
            },
        ),
        60,
        600,
        cone_arc,
        own=True,
    ),
    "sections": CaseSet(
        Description(
            "Bars and pipes",
            "Twenty sorts of sections that are no circle, drawn out to bars of 1 to 5 widths with all sides "
            "and no ends: three to eight faces, rectangles, L, U, T, I and C, ellipses, half-round, "
            "stadium, star. In an eighth of the clouds no noise, else 0.03 to 3% of the width "
            "(independent, along the normal), 200 to 20,000 points (all log-uniform). Every fourth cloud is "
            "a round pipe. Grouped by how far the clean section is off the nearest circle or line (root "
            "mean square) in noise scales. The right answer is `no_fit`, of a pipe the cylinder; below 3 "
            "noise scales `ambiguous` will do, below 1 nothing is asked.",
            {"deviation": (PIPE, *_names(DEVIATIONS_SEEN)), "section": (PIPE, *SECTIONS)},
        ),
        80,
        1200,
        sections,
    ),
    "foreign": CaseSet(
        Description(
            "Shapes that are no primitive",
            "Scans of six other shapes: ellipsoids whose half-axes differ by a fifth at least (1, 0.4 to "
            "0.8, from 0.25), corners of boxes with sides of 0.5 to 1, cylinders 1 to 5 radii long with flat "
            "or round caps, one in view, saddles z = a x^2 - b y^2 (a, b from 0.3 to 1) over a square of "
            "side 2, spheres with six waves of 4 to 12% of the radius, and two pieces of primitives side by "
            "side, the second 0.4 to 1 times as large and with 30 to 70% of the points. Of shapes of "
            "several surfaces none has over 75% of the points. 200 to 10,000 points from one to three "
            "stations, noise of 0.01 to 1% of the extent (both log-uniform), in half of the clouds up to "
            "10% gross outliers. Grouped by how far the clean shape, where it is seen, is off the nearest "
            "primitive of any kind (root mean square), in noise scales or in 0.2% of the extent, which "
            "sensors and parts bow by, whichever is larger. The right answer is `no_fit`; below 3 "
            "`ambiguous` or an answer that names the deviation will do, below 1 nothing is asked. Methods "
            "that are given the kind are not asked.",
            {"deviation": _names(DEVIATIONS_SEEN), "shape": SHAPES},
        ),
        60,
        300,
        foreign,
    ),
}
"""By name, in the order of the report."""
