"""The floor of each step: what must be computed of a cloud, at the speed of the machine and nothing else.

Operations are counted from the formulas of `fitting/primitives/*.h` and the constants of the algorithms, for
the number of points, the kinds that were tried and the kind that was answered. The algorithm stays as it is;
what the floor leaves out is everything around it: calls, temporary arrays, memory that is read twice, numbers
that nobody uses. One call of a Python function is granted for each piece of work. Numbers of rounds that
depend on the cloud stand here as what is usual, so a floor is right within a factor of two.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, log, log2

from primfit.fitting.cloud.cloud import NORMAL_POINTS, SAMPLE_POINTS, WORKING_POINTS
from primfit.fitting.cloud.normals import NEIGHBOURS
from primfit.fitting.cloud.patches import GRAIN, PATCHES
from primfit.fitting.primitives import PRIMITIVES, SIZES, names_of
from primfit.fitting.search.anneal import SHRINK
from primfit.fitting.search.starts import STARTS

from .ceilings import Ceilings


@dataclass(frozen=True)
class Work:
    """Operations, as `Ceilings` counts them; `moved` and `hashed` are bytes, `calls` pieces of work."""

    flops: float = 0.0
    roots: float = 0.0
    logs: float = 0.0
    compares: float = 0.0
    moved: float = 0.0
    hashed: float = 0.0
    calls: float = 0.0

    def __add__(self, other: "Work") -> "Work":
        mine, theirs = vars(self), vars(other)
        return Work(**{name: mine[name] + theirs[name] for name in mine})

    def __mul__(self, times: float) -> "Work":
        return Work(**{name: times * value for name, value in vars(self).items()})

    def seconds(self, best: Ceilings) -> float:
        """The arithmetic, or the memory where that takes longer, and the calls."""
        arithmetic = (
            self.flops / best.flops
            + self.roots / best.roots
            + self.logs / best.logs
            + self.compares / best.compares
            + self.hashed / best.hashed
        )
        return max(arithmetic, self.moved / best.bytes) + self.calls / best.calls


ONCE = Work(calls=1.0)


SEARCH_POINTS = 512
"""Points that annealing runs on."""


@dataclass(frozen=True)
class Facts:
    """What the work on a cloud depends on.

    Attributes
    ----------
    points : their number
    tried, answered : the kinds that were fitted, and those that the answer names
    exact : points lie on the answer within their rounding; then searches end early
    spared : a rough fit of the ranking led to exact points, so that no starts were needed
    rivals : how often it was asked how far a kind that is not tried is from the best surface
    answer_bytes : of the answer in JSON
    """

    points: int
    tried: tuple[str, ...]
    answered: tuple[str, ...]
    exact: bool
    spared: bool
    rivals: int
    answer_bytes: int

    @property
    def working(self) -> int:
        return min(self.points, WORKING_POINTS)

    @property
    def sample(self) -> int:
        return min(self.points, SAMPLE_POINTS)

    @property
    def searched(self) -> int:
        return min(self.points, SEARCH_POINTS)


# -- passes over points -------------------------------------------------------------------------------------

DISTANCE = {
    "plane": Work(flops=8),  # 3 differences, a product with the normal
    "sphere": Work(flops=9, roots=1),  # 3 differences, a square, a root, less the radius
    "cylinder": Work(flops=20, roots=1),  # `around_axis`: differences 3, height 5, foot 6, square 5, root; 1
    "cone": Work(flops=27, roots=1),  # `around_axis` 19; rho cos t - h sin t - s 4; behind the apex? 4
    "torus": Work(flops=24, roots=2),  # `around_axis` 19; rho - R, a square and its root 4; less r
}
"""Signed distance of a point from each kind."""

SLOPES = {
    "plane": Work(flops=10),  # the other two coordinates in the plane
    "sphere": Work(flops=4, roots=1),  # 1 / length, times three
    "cylinder": Work(flops=17, roots=1),  # direction outwards in the basis 13, four derivatives 4
    "cone": Work(flops=23, roots=1),  # direction 13, lean 3, tilts 2, shifts 2, angle 3
    "torus": Work(flops=24, roots=2),  # direction 13, gradient 3, lean 3, tilts 2, shifts 2, signs 1
}
"""What its derivatives take beyond that."""

WEIGHT = Work(flops=6, roots=1)
"""Square in scales and the weight of a kernel."""
COST = Work(flops=6, roots=1)
"""What a distance costs, summed up."""


def equations(dof: int) -> Work:
    """A point's part of J^T W J (lower triangle) and J^T W d: a weight times each, then fused sums."""
    return Work(flops=dof + dof * (dof + 1) + 2 * dof)


def step(kind: str) -> Work:
    """Of a point in a step of Gauss and Newton: derivatives, equations; then the cost where it leads."""
    seen = DISTANCE[kind] + SLOPES[kind] + WEIGHT + equations(PRIMITIVES[kind].dof)
    return seen + DISTANCE[kind] + COST


SELECTION = 3.0
"""Compares of a number while the median is found."""


def median(count: int) -> Work:
    return Work(flops=count, compares=SELECTION * count)


def sort(count: int) -> Work:
    return Work(compares=count * log2(max(count, 2)))


CORE_ROUNDS = 6
"""Rounds until the scale of a core is at rest, usually."""


def core(count: int) -> Work:
    """The scale of the core of distances: a median, and weighted sums (6 flops)."""
    return median(count) + Work(flops=6) * (CORE_ROUNDS * count)


# -- steps --------------------------------------------------------------------------------------------------


def read(facts: Facts) -> Work:
    """The coordinates are read once and written once."""
    return ONCE + Work(moved=48.0 * facts.points)


def check(facts: Facts) -> Work:
    """Each coordinate is held against the largest, the smallest and infinity."""
    return ONCE + Work(flops=9.0 * facts.points, moved=24.0 * facts.points)


def order(facts: Facts) -> Work:
    """A key a point (its squared distance from a centre, 9 flops), a sort, and the points as it says; a
    random sample of the working points by another sort."""
    n = facts.points
    return ONCE + Work(flops=12.0 * n, moved=60.0 * n) + sort(n) + sort(facts.working)


def rounding(facts: Facts) -> Work:
    """Each coordinate in some steps (times, rounded, difference: 3 flops): a float32, a decimal or two."""
    return ONCE + Work(flops=27.0 * facts.points, moved=24.0 * facts.points)


def frame(facts: Facts) -> Work:
    """Centre and scale (9 + 6 flops), scatter (12), turned to the axes (15); halves down to the grain."""
    n, m = facts.points, facts.working
    halvings = log2(max(PATCHES, m // GRAIN)) + log2(PATCHES)
    patches = Work(compares=SELECTION * m * halvings, moved=16.0 * m * halvings)
    return ONCE + Work(flops=42.0 * n, moved=72.0 * n) + patches


def normals(facts: Facts) -> Work:
    """A tree (n log2 n compares); for each place the leaves about it: thrice the neighbours, 8 flops each;
    the scatter of the neighbours (15) and its eigenvectors in closed form (150 flops, 6 roots, 4 angles)."""
    places, m = min(NORMAL_POINTS, facts.points), facts.working
    a_place = Work(
        flops=24.0 * NEIGHBOURS + 15.0 * NEIGHBOURS + 150.0,
        roots=6.0,
        logs=4.0,
        compares=3.0 * NEIGHBOURS * log2(NEIGHBOURS) + log2(max(m, 2)),
    )
    return ONCE + sort(m) + a_place * places + Work(moved=24.0 * m)


ROUGH_STEPS, ROUGH_STARTS = (48 * 4, 64 * 8 * 3, 512 * 3), 12
"""Points times steps in the stages of a rough fit: of each start, and of those that are left."""
PAIRS, PAIR = 2016, Work(flops=40, roots=3, logs=1)
"""Pairs of points that are compared, and an angle and a distance of each."""
WEIGHTS = 130 * 128 + 128 * 64 + 64 * 5
"""Of the network, a fused operation each."""


def rank(facts: Facts) -> Work:
    """A rough fit of each kind, pairs of points, histograms of the normals, the network."""
    first, later, last = ROUGH_STEPS
    rough = [step(kind) * (ROUGH_STARTS * first + later + last) for kind in DISTANCE]
    solved = Work(flops=4.0 * 28 * 96 * ROUGH_STARTS * len(DISTANCE))
    histograms = Work(flops=60.0, logs=1.0) * min(facts.points, 512)
    return sum(rough, ONCE) + solved + PAIR * PAIRS + histograms + Work(flops=2.0 * WEIGHTS)


GUESSES = {"plane": 25, "sphere": 25, "cylinder": 17, "cone": 17, "torus": 38}
"""Initial guesses of each kind; those of cylinders that tori are bent from come in `starts`."""
GUESS = Work(flops=4.0 * 40)
"""Of a point in a guess: four rounds of four weighted linear equations."""


GUESS_POINTS = 160
RACE = ((64, 4, 12), (GUESS_POINTS, 6, 12))
"""Points, steps and starts that are left, by stages in which starts race, as the search has them at best."""
SETTLING = 10
"""Steps that those which are left take more, unless exact points end the search."""


def race(kind: str, guesses: int, points: int) -> Work:
    """Of so many guesses: they are solved for, and step, with a median before each step."""
    total, left = GUESS * (min(points, GUESS_POINTS) * guesses), guesses
    for most, steps, kept in RACE:
        n = min(points, most)
        total += (step(kind) * n + median(n)) * (steps * left)
        left = min(left, kept)
    return total


def starts(facts: Facts) -> Work:
    """A race of the guesses, of cylinders, too, where a torus is sought, which are bent into some of its own;
    more steps of those that are left, where no exact points end the search; nothing where it was spared."""
    n, total = min(GUESS_POINTS, facts.points), Work()
    if facts.spared:
        return total
    for kind in facts.tried:
        total += race(kind, GUESSES[kind], facts.points) + ONCE * 2.0
        if kind == "torus":
            total += race("cylinder", GUESSES["cylinder"], facts.points)
        if not facts.exact:
            total += (step(kind) * n + median(n)) * (SETTLING * RACE[-1][-1])
    return total


SPAN = 100.0
"""Scale at the start of annealing over that of the noise, usually."""
SCALES = ceil(log(SPAN) / log(1.0 / SHRINK))
EXACT_SCALES = 4
"""Scales on the way to exact points: the scale drops at once where most points are close."""


def anneal(facts: Facts) -> Work:
    """Two steps at each scale, and the core of the distances: of the best start, and of `STARTS` others where
    there are no exact points."""
    n, total = facts.searched, Work()
    scales, ends = (EXACT_SCALES, 1) if facts.exact else (SCALES, 1 + STARTS)
    for kind in facts.tried:
        total += ((step(kind) * (2 * n) + core(n)) * scales + median(n)) * ends + ONCE
    return total


POLISH_ROUNDS, POLISH_STEPS = 3, 3
"""Rounds of scale and surface before Anderson's method, and steps in each; then rounds as many as numbers."""


def polish(facts: Facts) -> Work:
    """On all working points: rounds, then a pass for each number, one for the scale, and the last steps; on
    exact points two rounds of two steps."""
    n, total = facts.working, Work()
    for kind in facts.tried:
        numbers = PRIMITIVES[kind].dof + 1
        if facts.exact:
            total += step(kind) * (4.0 * n) + ONCE
            continue
        total += step(kind) * (n * (POLISH_ROUNDS * POLISH_STEPS + numbers + 2))
        total += core(n) * (POLISH_ROUNDS + numbers) + ONCE
    if facts.points > n:
        total += step(facts.tried[-1]) * (2.0 * facts.points)
    return total


MIXTURE_ROUNDS = 10
FIELDS = 18 + 20
"""Sizes and ranges of noise that are weighed: each field alone, and the pairs that help, usually."""


def evidence(facts: Facts) -> Work:
    """Noise and outliers (rounds of 10 flops and an exponential of a sample), derivatives at all points,
    means of patches, and a factorisation of the patches' covariance for each explanation. Beside exact points
    no fields are looked for."""
    n, total = facts.working, Work()
    for kind in facts.tried:
        dof = PRIMITIVES[kind].dof
        total += DISTANCE[kind] * n + Work(flops=10.0, roots=1.0, logs=1.0) * (MIXTURE_ROUNDS * facts.sample)
        total += ONCE
        if facts.exact:
            continue
        passes = DISTANCE[kind] + SLOPES[kind] + Work(flops=2.0 * (dof + 4) + 3.0)
        a_field = Work(flops=PATCHES**3 / 3.0 + 2.0 * PATCHES**2 * (dof + 1), logs=PATCHES**2 / 4.0)
        total += passes * n + a_field * FIELDS + Work(moved=8.0 * n * (dof + 4))
    return total


def verdict(facts: Facts) -> Work:
    """Some means over the points of each kind; the rest is a few numbers."""
    return (ONCE + Work(flops=4.0 * facts.working)) * len(facts.tried)


def rivals(facts: Facts) -> Work:
    """The feet of few points, and a race of the guesses of the kind, of a usual one, towards them."""
    return (race("cylinder", GUESSES["cylinder"], facts.points) + ONCE) * facts.rivals


TRIANGLE = Work(flops=60.0, roots=3.0)
"""Of a point in a triangulation of the plane: two triangles, a circumscribed circle each."""


def extents(facts: Facts) -> Work:
    """Of each answer: feet (a gradient), angles and heights, two sorts, two grids of cells; of a plane a
    triangulation, from which the outlines follow."""
    n, total = facts.working, Work()
    for kind in facts.answered:
        total += (DISTANCE[kind] + SLOPES[kind] + Work(flops=12.0, logs=2.0)) * n + sort(n) * 2.0 + ONCE
        if kind == "plane":
            total += TRIANGLE * n
    return total


ENDS, PROFILE_ROUNDS = 2, 6


def uncertainty(facts: Facts) -> Work:
    """Of each answer: bread and meat, the means of patches under each explanation where there are fields, and
    the profile of each size: rounds for either end of its interval."""
    n, total = facts.working, Work()
    for kind in facts.answered:
        dof = PRIMITIVES[kind].dof
        sizes = sum(name in SIZES for name in names_of(kind))
        total += (DISTANCE[kind] + SLOPES[kind] + equations(dof) * 2.0) * n + ONCE
        if not facts.exact:
            total += Work(flops=2.0 * PATCHES**2 * dof) * FIELDS
        total += step(kind) * (n * sizes * ENDS * PROFILE_ROUNDS)
    return total


def assemble(facts: Facts) -> Work:
    """A few numbers of each answer, back in the units of the input."""
    return ONCE * len(facts.answered)


def serialise(facts: Facts) -> Work:
    """The points are hashed for the receipt, and the answer is written: a byte a few operations."""
    return ONCE + Work(hashed=24.0 * facts.points, flops=20.0 * facts.answer_bytes)


FLOORS: dict[str, Callable[[Facts], Work]] = {
    "read": read,
    "check": check,
    "order": order,
    "rounding": rounding,
    "frame, patches": frame,
    "normals": normals,
    "rank": rank,
    "starts": starts,
    "anneal": anneal,
    "polish": polish,
    "evidence": evidence,
    "verdict": verdict,
    "rivals": rivals,
    "extents": extents,
    "uncertainty": uncertainty,
    "assemble": assemble,
    "serialise": serialise,
}
"""By the steps of `table.STEPS`."""
