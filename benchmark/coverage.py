"""Do the 95% intervals hold the truth in 95 of 100 cases? Scans whose noise is known, and what is counted.

A cloud is what a virtual scanner sees of a piece, without its noise; the noise is put on along the normal:
the same everywhere (`independent`), three times as large at one end as at the other (`uneven`), a random
field that neighbours share smoothly (`correlated`) or roughly, over one to five spacings (`exponential`), or
half of it in waves along scan lines (`wavy`). Or it acts `along the ray`, as a scanner's does; or the part is
`bowed` by half a noise scale under independent noise. `arcs` are 30 to 60 degrees of a turn under independent
noise, `correlated arcs` are both, `few` have at most ten points for a parameter, `minimal` have one, which
deserves a warning and no intervals. The kind is given: intervals are measured, not recognition.
"""

from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.random import Generator
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from primfit.fitting.cloud.frame import Frame
from primfit.fitting.extents import extents_of
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives import DIRECTIONS, is_length, names_of, values_of
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.solver.refine import CODES, linearize
from primfit.fitting.uncertainty._profile import numbers
from primfit.fitting.uncertainty.intervals import spread
from primfit.fitting.uncertainty.values import Uncertainty
from primfit.fitting.uncertainty.warnings import HALF_TURN, SHORT_ARC, WEAK_AXIS, WEAK_SIZE
from primfit.synthetic import cloud
from primfit.synthetic.bows import DEVIATIONS, DEVIATIONS_OF, piece_of
from primfit.synthetic.noise import sigma_weights
from primfit.synthetic.recipes import KINDS, Range
from primfit.synthetic.scanner import STEEPEST, log_uniform

from .cases import SCAN
from .measures import diagonal
from .pieces import feet

LAWS = (
    "independent",
    "uneven",
    "correlated",
    "arcs",
    "correlated arcs",
    "few",
    "minimal",
    "along the ray",
    "exponential",
    "wavy",
    "bowed",
)
ARCS = ("arcs", "correlated arcs")
NOISE, ARC_NOISE = Range(1e-4, 3e-3), Range(3e-4, 1e-2)
"""Shares of the extent, log-uniform; the second of `ARCS`."""
THICK, THIN_SHARE = 0.1, 0.1
"""Noise is at most this share of the radius that this share of the points is below: a needle that is as thin
as its noise has no inside and outside to be told."""
POINTS = Range(1000.0, 1000.0)
WAVES = 200
LENGTH = Range(0.02, 0.05)
"""Of the correlation exp(-(h / length)^2), in extents."""
LARGEST_RATIO = 3.0
SPACINGS = Range(1.0, 5.0)
"""Range of the correlation exp(-h / range), in mean distances of neighbours."""
NEIGHBOURS = 8
"""The distance of so many neighbours gives the area of a point."""
WAVE = Range(4.0, 20.0)
"""Length of the waves along a scan line, in spacings; lines lie a spacing apart."""
WAVE_SHARE = 0.5
"""Of the variance, in waves whose phases differ from line to line; the rest is independent."""
BOW = 0.5
"""Standard deviation of the normal law of a bow's size, in noise scales: sign and size are random, so that
half a scale is its root mean square."""
JITTER = 1e-9
"""Added to a correlation, so that points that nearly coincide do not make it singular."""
UNSAID = ("exponential", "wavy", "bowed")
"""Whether these deserve to be called correlated depends on ranges and sizes that are drawn."""
MARGIN = 0.15
"""Clouds this close, relatively, to the limit of a warning neither deserve it nor not."""

Z_95 = 1.959964


@dataclass(frozen=True, eq=False)
class Scene:
    """A cloud (N, 3), its surface, and the standard deviation of the noise of its points."""

    points: Array
    truth: Primitive
    sigma: Array
    law: str


@dataclass(frozen=True)
class Outcome:
    """What one cloud showed.

    Attributes
    ----------
    covered : by number (vectors together), the share of its intervals that hold the truth
    relative : by number, the square of the error over its Cramer-Rao value; independent noise only, and
        where no interval is a profile: there it is no bound of what is not linear
    given, deserved : the warnings given, and for each whether the cloud deserves it, None near the limit
    profiled : whether any interval is a profile
    """

    law: str
    kind: str
    status: str
    covered: Mapping[str, float]
    relative: Mapping[str, float]
    given: frozenset[str]
    deserved: Mapping[str, bool | None]
    profiled: bool


def scene(law: str, kind: str, seed: int, index: int) -> Scene:
    """Cloud `index` of a law and a kind."""
    rng = np.random.default_rng([seed, index, KINDS.index(kind), LAWS.index(law), 8])
    arc = rng.uniform(30.0, 60.0) if law in ARCS else rng.uniform(60.0, 360.0)
    recipe = replace(
        SCAN,
        seed=seed,
        kinds=(kind,),
        arc=Range(arc, arc),
        whole=0.0,
        noiseless=1.0,
        points=POINTS,
        size=Range(1.0, 1.0),
    )
    drawn = cloud(recipe, index)
    assert drawn.primitive is not None and drawn.outliers is not None
    points = feet(drawn.primitive, drawn.points[~drawn.outliers])
    if law in ("few", "minimal"):
        dof = drawn.primitive.dof
        count = dof if law == "minimal" else rng.integers(dof + 2, 10 * dof)
        points = points[rng.permutation(len(points))[:count]]
    extent = diagonal(points)
    normals = drawn.primitive.gradient(points)
    noise = extent * log_uniform(rng, ARC_NOISE if law in ARCS else NOISE)
    noise = min(noise, THICK * thickness(drawn.primitive, points))
    sigma, field = np.full(len(points), noise), rng.standard_normal(len(points))
    if law == "uneven":
        along = points @ rng.standard_normal(3)
        sigma = noise * LARGEST_RATIO ** ((along - along.mean()) / np.ptp(along))
    if law.startswith("correlated"):
        field = waves(rng, points / (extent * rng.uniform(LENGTH.low, LENGTH.high)))
    if law == "exponential":
        field = exponential(rng, points)
    if law == "wavy":
        field = wavy(rng, points)
    if law == "bowed":
        field = field + bow(rng, drawn.primitive, points)
    if law == "along the ray":
        assert drawn.stations is not None and drawn.station is not None
        rays, weights = rays_to(points, drawn.stations[drawn.station[~drawn.outliers]], normals)
        along = noise * weights * field
        sigma = noise * weights * np.abs(np.einsum("ij,ij->i", rays, normals))
        return Scene(points + along[:, None] * rays, drawn.primitive, sigma, law)
    return Scene(points + (sigma * field)[:, None] * normals, drawn.primitive, sigma, law)


def rays_to(points: Array, stations: Array, normals: Array) -> tuple[Array, Array]:
    """Unit rays (N, 3) from stations (N, 3) to the points, and how the noise of each compares (N,)."""
    sight = points - stations
    distance = np.linalg.norm(sight, axis=1)
    rays = sight / distance[:, None]
    cosine = np.abs(np.einsum("ij,ij->i", rays, normals))
    return rays, sigma_weights(distance, np.maximum(cosine, np.cos(STEEPEST)))


def spacing(points: Array) -> float:
    """The side of the square that a point has to itself, in the median."""
    reach = cKDTree(points).query(points, NEIGHBOURS + 1)[0][:, -1]
    return float(np.median(reach) * np.sqrt(np.pi / NEIGHBOURS))


def exponential(rng: Generator, points: Array) -> Array:
    """A normal field of unit variance with the correlation exp(-h / range), by Cholesky's factor of it."""
    reach = spacing(points) * rng.uniform(SPACINGS.low, SPACINGS.high)
    correlation = np.exp(-cdist(points, points) / reach)
    factor = np.linalg.cholesky(correlation + JITTER * np.eye(len(points)))
    return np.asarray(factor @ rng.standard_normal(len(points)))


def wavy(rng: Generator, points: Array) -> Array:
    """Independent noise, and waves along the lines in which parallel planes cut the surface."""
    along, across = (points @ np.linalg.qr(rng.standard_normal((3, 2)))[0] / spacing(points)).T
    line = np.floor(across - across.min()).astype(int)
    phase = rng.uniform(0.0, 2.0 * np.pi, line.max() + 1)[line]
    wave = np.sqrt(2.0) * np.cos(2.0 * np.pi * along / rng.uniform(WAVE.low, WAVE.high) + phase)
    white = rng.standard_normal(len(points))
    return np.asarray(np.sqrt(WAVE_SHARE) * wave + np.sqrt(1.0 - WAVE_SHARE) * white)


def bow(rng: Generator, truth: Primitive, points: Array) -> Array:
    """A bow, lobes or a barrel of random size, in noise scales; its mean over the points is 0."""
    deviation = str(rng.choice(DEVIATIONS_OF[truth.kind]))
    field = DEVIATIONS[deviation](rng, piece_of(rng, truth, points))
    field = field - field.mean()
    return np.asarray(BOW * rng.standard_normal() * field / field.std())


def thickness(truth: Primitive, feet: Array) -> float:
    """The radius of curvature that a tenth of the points are below; infinite for a plane."""
    if truth.kind == "plane":
        return np.inf
    if isinstance(truth, Cone):
        height = (feet - truth.apex) @ truth.axis
        return float(np.quantile(height, THIN_SHARE) * np.tan(truth.half_angle) / np.cos(truth.half_angle))
    return float(truth.minor_radius if isinstance(truth, Torus) else truth.radius)  # type: ignore[attr-defined]


def waves(rng: Generator, points: Array) -> Array:
    """A normal field of unit variance with the correlation exp(-h^2), as a sum of random waves.

    Source: Shinozuka and Deodatis, "Simulation of stochastic processes by spectral representation", Applied
    Mechanics Reviews 44, 1991.
    """
    wave = np.sqrt(2.0) * rng.standard_normal((WAVES, 3))
    phase = points @ wave.T + rng.uniform(0.0, 2.0 * np.pi, WAVES)
    return np.sqrt(2.0 / WAVES) * (np.cos(phase) @ rng.standard_normal(WAVES))


def outcome(law: str, kind: str, seed: int, index: int) -> Outcome:
    drawn = scene(law, kind, seed, index)
    found = recognize(drawn.points, Config(kinds=(kind,)))
    known = found.uncertainty
    if known is None or found.primitive is None:
        return Outcome(law, kind, found.status, {}, {}, frozenset(), {}, False)
    given = frozenset(warning.code for warning in known.warnings)
    if law == "minimal":
        return Outcome(law, kind, found.status, {}, {}, given, {"minimal_sample": True}, False)
    if known.covariance is None:
        return Outcome(law, kind, found.status, {}, {}, frozenset(), {}, False)
    bound = cramer_rao(drawn)
    covered, relative = scored(found.primitive, known, drawn, bound)
    profiled = any(interval.method == "profile" for interval in known.intervals.values())
    return Outcome(
        law,
        kind,
        found.status,
        covered,
        relative if law in ("independent", "arcs") and not profiled else {},
        given,
        deserved(drawn, bound),
        profiled,
    )


def cramer_rao(drawn: Scene) -> Array:
    """Covariance (P, P) of the true numbers that no unbiased estimate beats under independent noise."""
    frame = Frame.of(drawn.points)
    truth = frame.bring(drawn.truth).canonical(np.zeros(3))
    rows = linearize(truth, frame.normalize(feet(drawn.truth, drawn.points)))[1]
    by_step = numbers(CODES[truth.kind], truth.row(), np.zeros(3))[1]
    units = np.where([is_length(name) for name in names_of(truth.kind)], frame.scale, 1.0)
    by_step, rows = units[:, None] * by_step, rows * (frame.scale / drawn.sigma)[:, None]
    _, sizes, directions = np.linalg.svd(rows, full_matrices=False)
    half = by_step @ (directions.T / sizes)
    return np.asarray(half @ half.T)


def scored(
    answer: Primitive, known: Uncertainty, drawn: Scene, bound: Array
) -> tuple[dict[str, float], dict[str, float]]:
    """What is covered, and mean squares over those of the bound; a `point` is compared near the centroid."""
    frame = Frame.of(drawn.points)
    truth = frame.restore(frame.bring(drawn.truth).canonical(np.zeros(3)))
    names, true, got = names_of(truth.kind), values_of(truth), values_of(answer)
    hits: dict[str, list[float]] = {}
    squares: dict[str, list[float]] = {}
    for i, name in enumerate(names):
        interval = known.intervals.get(name)
        if interval is None:
            continue
        low = -np.inf if interval.low is None else interval.low
        high = np.inf if interval.high is None else interval.high
        group = name.split(".")[0]
        hits.setdefault(group, []).append(float(low <= true[i] <= high))
        squares.setdefault(group, []).append(float((got[i] - true[i]) ** 2 / bound[i, i]))
    if known.direction is not None:
        ours, theirs = (getattr(s, "normal" if s.kind == "plane" else "axis") for s in (answer, truth))
        angle = np.arctan2(np.linalg.norm(np.cross(ours, theirs)), abs(ours @ theirs))
        hits["direction"] = [float(angle <= known.direction.radius_95)]
    if known.position is not None:
        along = answer.axis if answer.kind == "cylinder" else answer.normal  # type: ignore[attr-defined]
        offset = answer.point - truth.point  # type: ignore[attr-defined]
        aside = abs(offset @ along) if answer.kind == "plane" else np.linalg.norm(np.cross(offset, along))
        hits["position"] = [float(aside <= known.position.radius_95)]
    return _means(hits), _means(squares)


def _means(values: Mapping[str, list[float]]) -> dict[str, float]:
    return {name: float(np.mean(each)) for name, each in values.items()}


def deserved(drawn: Scene, bound: Array) -> dict[str, bool | None]:
    """Which warnings a cloud deserves, from its true surface and noise; None near the limit."""
    truth, n, dof = drawn.truth, len(drawn.points), drawn.truth.dof
    names, values = names_of(truth.kind), values_of(truth)
    extents = extents_of(truth, drawn.points, 0.0)
    arcs = [] if extents is None else extents.arcs.values()
    least = min(arcs, default=np.inf)
    sided = [arc for arc in arcs if arc >= SHORT_ARC]
    few = drawn.law == "few"
    result: dict[str, bool | None] = {
        "minimal_sample": False,
        "few_points": n < 5 * dof,
        "short_arc": None if few else _below(least, SHORT_ARC),
        "correlated_noise": None if few or drawn.law in UNSAID else drawn.law.startswith("correlated"),
    }
    near_short = any(_below(arc, SHORT_ARC) is None for arc in arcs)
    result["one_sided"] = None if few or near_short else _below(min(sided, default=np.inf), HALF_TURN)
    if drawn.law in ("independent", "arcs"):
        halves = Z_95 * np.sqrt(np.diag(bound)) / np.maximum(np.abs(values), 1e-300)
        sizes = [halves[i] for i, name in enumerate(names) if "." not in name]
        result["weak_size"] = _above(max(sizes, default=0.0), WEAK_SIZE)
        if truth.kind != "sphere":
            first = next(i for i, name in enumerate(names) if name.split(".")[0] in DIRECTIONS)
            axes = np.linalg.eigvalsh(bound[first : first + 3, first : first + 3])[1:]
            result["weak_axis"] = _above(spread(np.diag(axes), Z_95).radius_95, WEAK_AXIS)
    return result


def _below(value: float, limit: float) -> bool | None:
    return None if abs(value - limit) <= MARGIN * limit else bool(value < limit)


def _above(value: float, limit: float) -> bool | None:
    return None if abs(value - limit) <= 2.0 * MARGIN * limit else bool(value > limit)


def measure(count: int, seed: int, processes: int, laws: tuple[str, ...] = LAWS) -> list[Outcome]:
    """`count` clouds of each kind and law; planes have no arcs."""
    found: list[Outcome] = []
    with ProcessPoolExecutor(processes) as pool:
        for law in laws:
            for kind in KINDS[law in ARCS :]:
                found += pool.map(partial(outcome, law, kind, seed), range(count), chunksize=10)
    return found
