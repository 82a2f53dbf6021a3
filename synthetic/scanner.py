"""Clouds of a virtual scanner: pieces of primitives as a few stations see them.

A cloud is made in the primitive's canonical frame (`see`): a piece is drawn, stations are set up, each casts
a grid of rays at equal angles and keeps what it hits first, so that hidden sides stay empty and the density
falls with range and incidence. Noise acts along the rays. Then (`deliver`) the cloud gets its pose, its
unit, gross outliers and the rounding of its file. Lengths in the canonical frame are those of the piece.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from primfit.fitting.primitives import PRIMITIVES
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

from .canonical import ORIGIN, TURN, Z_AXIS
from .clouds import SyntheticCloud
from .noise import correlated, edges, gross_outliers, rounded, sigma_weights
from .patches import Patch
from .recipes import ForeignRecipe, Range, ScannerRecipe
from .telling import bearable_noise, deviation

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]
Mode = Literal["solid", "shell", "hollow"]

MODES: tuple[tuple[Mode, float], ...] = (("solid", 0.6), ("shell", 0.25), ("hollow", 0.15))
"""A solid seen from outside, a thin sheet seen from either side, a hole or bowl seen from within."""
STANDOFF = Range(1.5, 20.0)
"""Distance of a station from the centre of the piece, in radii of the sphere about it; log-uniform."""
STEEPEST = np.radians(85.0)
"""Incidence beyond which nothing comes back."""
COARSE = 20
"""Side of the grid of rays that is cast first, to see which window the piece fills."""
WINDOW_MARGIN = 0.06
LINE_RATIO = Range(1.0, 3.0)
"""Distance of the scan lines over the distance of the points in a line."""
LEAST_DEVIATION = 2e-3
"""Pieces that deviate less from a simpler kind, in extents, are drawn again by recipes that are decidable."""
POINTS_PER_UNKNOWN = 6
"""Such recipes give the surface at least so many points for each degree of freedom of the primitive."""
OVERSAMPLED = 1.2
MOST_RAYS = 12_000_000
TRIES = 12

CORRELATED_CLOUDS, CORRELATION_LENGTH = 0.3, Range(2.0, 8.0)
"""How many clouds have correlated noise, over how many rays."""
CORRELATION_REACH = 0.08
"""Correlation over more than this share of the grid's side would be a dent, not noise; it is shortened."""
MIXED_CLOUDS, MIXED_SHARE, MIXED_REACH = 0.25, Range(0.1, 0.6), Range(0.02, 0.2)
"""How many clouds have mixed pixels, which share of their edge points, and how far behind, in extents."""
MOST_MIXED = 0.1
"""Of the points of a cloud: nearly all rays of a sparse grid are at an edge."""
CROPPED_CLOUDS, CROP_KEEPS = 0.3, Range(0.4, 0.95)
FRUSTUM, FRUSTUM_START = 0.7, Range(0.05, 0.85)
"""How many cones do not reach the apex, and where they start on their generatrix."""
WHOLE_TUBE, TUBE_ARC = 0.5, Range(60.0, 360.0)
PLANE_SIDES = Range(0.1, 1.0)
"""Shorter over longer side, log-uniform."""
MOST_DOMINANT_NEIGHBOUR = 0.25
"""Beyond this share outliers are uniform in the box: a plane of more points would be a second segment."""

FILES = (("float64", 0.6), ("float32", 0.25), ("1 mm", 0.15))
COARSEST_STEP = 0.005
"""Rounding is left out where its step exceeds this share of the extent, or the noise that hides the kind."""
MILLIMETRES = 0.5
PLACES = (("near", 0.6), ("scanner", 0.25), ("far", 0.15))
"""Within three extents of the origin; with a station at the origin; at map coordinates (metres only)."""
FAR = Range(1e5, 5e6)


def log_uniform(rng: Generator, law: Range) -> float:
    return float(np.exp(rng.uniform(np.log(law.low), np.log(law.high))))


def pick(rng: Generator, choices: tuple[tuple[str, float], ...]) -> str:
    return choices[int(rng.choice(len(choices), p=[share for _, share in choices]))][0]


# -- the object ---------------------------------------------------------------------------------------------


def draw_patch(rng: Generator, recipe: ScannerRecipe, kind: str) -> Patch:
    """A piece of this kind; radii are 1 (a torus: the tube's), a cone's generatrix and a plane's side too."""
    degrees = 360.0 if rng.random() < recipe.whole else log_uniform(rng, recipe.arc)
    arc = np.radians(degrees)
    azimuth = (-arc / 2, arc / 2)
    match kind:
        case "plane":
            side = log_uniform(rng, PLANE_SIDES)
            return Patch(Plane(Z_AXIS, ORIGIN), (-0.5, 0.5), (-side / 2, side / 2))
        case "sphere":
            return Patch(Sphere(ORIGIN, 1.0), (-np.pi, np.pi), (0.0, arc / 2))
        case "cylinder":
            half = log_uniform(rng, recipe.slenderness) / 2
            return Patch(Cylinder(Z_AXIS, ORIGIN, 1.0), azimuth, (-half, half))
        case "cone":
            angle = np.radians(log_uniform(rng, recipe.half_angle))
            start = rng.uniform(FRUSTUM_START.low, FRUSTUM_START.high) if rng.random() < FRUSTUM else 0.0
            heights = (start * np.cos(angle), np.cos(angle))
            return Patch(Cone(ORIGIN, Z_AXIS, float(angle)), azimuth, heights)
        case "torus":
            tube = TURN if rng.random() < WHOLE_TUBE else np.radians(log_uniform(rng, TUBE_ARC))
            middle = rng.uniform(-np.pi, np.pi)
            torus = Torus(ORIGIN, Z_AXIS, log_uniform(rng, recipe.torus_ratio), 1.0)
            return Patch(torus, azimuth, (middle - tube / 2, middle + tube / 2))
    raise KeyError(kind)


# -- seeing it ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Window:
    """A scanner's grid of rays at equal angles: a frame (rows forward, left, up) and the angles in it."""

    origin: Array
    frame: Array
    azimuth: tuple[float, float]
    elevation: tuple[float, float]

    def rays(self, rows: int, columns: int) -> Array:
        """Unit directions (rows * columns, 3), scan line by scan line."""
        elevation, azimuth = np.meshgrid(
            cells(self.elevation, rows), cells(self.azimuth, columns), indexing="ij"
        )
        level = np.cos(elevation)
        local = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1)
        return local.reshape(-1, 3) @ self.frame

    def narrowed(self, seen: Mask) -> "Window":
        """The part of the window about the rays of a grid that hit, with a margin of a cell."""
        return Window(
            self.origin,
            self.frame,
            part(self.azimuth, np.logical_or.reduce(seen, axis=0)),
            part(self.elevation, np.logical_or.reduce(seen, axis=1)),
        )


def cells(span: tuple[float, float], count: int) -> Array:
    """The middles of `count` equal parts."""
    return span[0] + (span[1] - span[0]) * (np.arange(count) + 0.5) / count


def part(span: tuple[float, float], used: Mask) -> tuple[float, float]:
    width = (span[1] - span[0]) / len(used)
    first, last = np.flatnonzero(used)[[0, -1]]
    return max(span[0], span[0] + (first - 1) * width), min(span[1], span[0] + (last + 2) * width)


def window_at(rng: Generator, origin: Array, targets: Array) -> Window:
    """A window on the targets (N, 3), the scanner turned about its line of sight at random."""
    sight = targets - origin
    forward = sight.mean(axis=0) + 1e-12 * rng.standard_normal(3)
    frame = np.linalg.qr(np.stack([forward, *rng.standard_normal((2, 3))], axis=1))[0].T
    frame[0] *= np.sign(frame[0] @ forward)
    x, y, z = frame @ sight.T
    angles = np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))
    spans = []
    for values, limit in zip(angles, (np.pi, np.pi / 2), strict=True):
        margin = WINDOW_MARGIN * (values.max() - values.min()) + 1e-6
        spans.append((max(values.min() - margin, -limit), min(values.max() + margin, limit)))
    return Window(origin, frame, spans[0], spans[1])


@dataclass(frozen=True, eq=False)
class View:
    """What a station sees: per hit the distance, the cosine of the incidence, its direction and its ray."""

    origin: Array
    directions: Array
    distance: Array
    cosine: Array
    ray: Indices
    rows: int
    columns: int
    on_edge: Mask

    @property
    def points(self) -> Array:
        return self.origin + self.distance[:, None] * self.directions


def cast(patch: Patch, mode: Mode, window: Window, rows: int, columns: int) -> View:
    """The hits of a grid of rays that face the scanner."""
    directions = window.rays(rows, columns)
    distance, hit = patch.first_hits(window.origin, directions, solid=mode == "solid")
    ray = np.flatnonzero(hit)
    points = window.origin + distance[ray, None] * directions[ray]
    slope = np.einsum("ij,ij->i", patch.primitive.gradient(points), directions[ray])
    facing = {"solid": -slope, "shell": np.abs(slope), "hollow": slope}[mode]
    if isinstance(patch.primitive, Plane):
        facing = np.abs(slope)
    ray = ray[facing > np.cos(STEEPEST)]
    seen = np.zeros((rows, columns), dtype=bool)
    seen.ravel()[ray] = True
    return View(
        window.origin,
        directions[ray],
        distance[ray],
        facing[facing > np.cos(STEEPEST)],
        ray,
        rows,
        columns,
        edges(seen).ravel()[ray],
    )


def set_up(rng: Generator, patch: Patch, mode: Mode, distance: float | None = None) -> Array:
    """A place for a station: outside on the side that the piece faces, or on the hollow side of it.

    At this distance from the middle of the piece; None: as `STANDOFF` has it.
    """
    targets = patch.sample(rng, 64)
    normals = patch.primitive.gradient(targets)
    if mode == "hollow":
        normals = -normals
    faced = normals.mean(axis=0)
    center = (targets.max(axis=0) + targets.min(axis=0)) / 2
    radius = np.sqrt(((targets - center) ** 2).sum(axis=1).max())
    if mode == "hollow" and faced @ faced < 0.1:
        nearby = patch.sample(rng, 1)
        depth = 1.0 if isinstance(patch.primitive, Torus) else float(np.linalg.norm(nearby[0, :2]))
        inward = -patch.primitive.gradient(nearby)[0]
        return nearby[0] + depth * rng.uniform(0.5, 1.0) * inward
    direction = rng.standard_normal(3)
    direction += 2.0 * faced * np.linalg.norm(direction)
    if isinstance(patch.primitive, Plane):
        direction[2] *= rng.choice([-1.0, 1.0])
    away = log_uniform(rng, STANDOFF) * radius if distance is None else distance
    return center + away * direction / np.linalg.norm(direction)


def aim(patch: Patch, mode: Mode, window: Window) -> tuple[Window, float] | None:
    """The window narrowed to what is seen of the piece, and the share of its rays that hit; None: too few."""
    for _ in range(2):
        coarse = cast(patch, mode, window, COARSE, COARSE)
        if len(coarse.ray) < 4:
            return None
        seen = np.zeros((COARSE, COARSE), dtype=bool)
        seen.ravel()[coarse.ray] = True
        window = window.narrowed(seen)
    cover = len(cast(patch, mode, window, COARSE, COARSE).ray) / COARSE**2
    return (window, cover) if cover >= 0.01 else None


def look(rng: Generator, patch: Patch, mode: Mode, wanted: int) -> View | None:
    """About `wanted` hits, or slightly more, from a new station; None where it sees next to nothing."""
    window = window_at(rng, set_up(rng, patch, mode), patch.sample(rng, 256))
    aimed = aim(patch, mode, window)
    if aimed is None:
        return None
    window, cover = aimed
    rays = OVERSAMPLED * wanted / cover + 9
    ratio = log_uniform(rng, LINE_RATIO)
    wide, high = np.subtract(*window.azimuth[::-1]), np.subtract(*window.elevation[::-1])
    rows = max(3, round(np.sqrt(rays * high / (wide * ratio))))
    columns = max(3, round(rays / rows))
    if rows * columns > MOST_RAYS:
        return None
    return cast(patch, mode, window, rows, columns)


def crop(rng: Generator, points: Array) -> Mask:
    """What lies on one side of a random plane."""
    height = points @ rng.standard_normal(3)
    return height >= np.quantile(height, 1.0 - rng.uniform(CROP_KEEPS.low, CROP_KEEPS.high))


# -- a cloud in the canonical frame -------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Sight:
    """Points with noise, before their pose; `tolerable` is the noise that the shape bears."""

    kind: str
    primitive: Primitive | None
    points: Array
    mixed: Mask
    stations: Array
    station: Indices
    noise: float
    extent: float
    tolerable: float
    correlation: float = 0.0
    arc: float | None = None


def views_of(rng: Generator, recipe: ScannerRecipe, kind: str, wanted: int) -> tuple[Patch, list[View]]:
    """A piece and what one or a few stations see of it, at least `wanted` points together."""
    for _ in range(TRIES * TRIES):
        patch = draw_patch(rng, recipe, kind)
        mode: Mode = pick(rng, MODES)  # type: ignore[assignment]
        stations = int(rng.integers(1, recipe.stations, endpoint=True))
        tries = (look(rng, patch, mode, -(-wanted // stations)) for _ in range(TRIES))
        views = []
        for view in tries:
            if view is not None:
                views.append(view)
            if len(views) == stations:
                break
        if sum(len(view.ray) for view in views) >= wanted:
            return patch, views
    raise RuntimeError(f"no {kind} was seen with {wanted} points")


def see(rng: Generator, recipe: ScannerRecipe, kind: str, count: int) -> Sight:
    """A piece of this kind as seen, `count` points."""
    for _ in range(TRIES):
        keeps = CROP_KEEPS.low if rng.random() < CROPPED_CLOUDS else 1.0
        patch, views = views_of(rng, recipe, kind, int(count / keeps) + 2)
        clean = np.concatenate([view.points for view in views])
        chosen = np.flatnonzero(crop(rng, clean)) if keeps < 1.0 else np.arange(len(clean))
        chosen = np.sort(rng.permutation(chosen)[:count])
        extent = float(np.linalg.norm(np.ptp(clean[chosen], axis=0)))
        least = deviation(patch, clean[chosen]) if recipe.decidable else np.inf
        if least >= LEAST_DEVIATION * extent:
            break
    clean = clean[chosen]
    directions = np.concatenate([view.directions for view in views])[chosen]
    station = np.repeat(np.arange(len(views)), [len(view.ray) for view in views])[chosen]

    length = log_uniform(rng, CORRELATION_LENGTH) if rng.random() < CORRELATED_CLOUDS else 0.0
    length = min(length, *(CORRELATION_REACH * min(view.rows, view.columns) for view in views))
    length = length if length > 1.0 else 0.0
    tolerable = bearable_noise(least, count / (1.0 + np.pi / 2 * length**2))
    noise = 0.0 if rng.random() < recipe.noiseless else extent * log_uniform(rng, recipe.noise)
    noise = min(noise, tolerable)
    weights = sigma_weights(
        np.concatenate([view.distance for view in views])[chosen],
        np.concatenate([view.cosine for view in views])[chosen],
    )
    fields = [correlated(rng, view.rows, view.columns, length).ravel()[view.ray] for view in views]
    along = noise * weights * np.concatenate(fields)[chosen]

    mixed = np.zeros(len(clean), dtype=bool)
    if rng.random() < MIXED_CLOUDS:
        share = rng.uniform(MIXED_SHARE.low, MIXED_SHARE.high)
        places = np.flatnonzero(np.concatenate([view.on_edge for view in views])[chosen])
        most = min(int(share * len(places)), int(MOST_MIXED * len(clean)))
        mixed[rng.permutation(places)[:most]] = True
        reach = extent * log_uniform(rng, MIXED_REACH)
        along[mixed] += reach * rng.random(np.count_nonzero(mixed))
    return Sight(
        kind,
        patch.primitive,
        clean + along[:, None] * directions,
        mixed,
        np.array([view.origin for view in views]),
        station,
        noise,
        extent,
        tolerable,
        length,
        arc_of(patch, clean),
    )


def arc_of(patch: Patch, points: Array) -> float | None:
    """Degrees that points on the surface cover: all but the largest gap in azimuth, or a cap that holds them.

    Of a sphere's caps the smaller of those about the piece's pole and about the points' mean direction.
    """
    if isinstance(patch.primitive, Plane):
        return None
    if isinstance(patch.primitive, Sphere):
        points = points / patch.primitive.radius
        middle = points.mean(axis=0)
        cosine = points @ np.column_stack([Z_AXIS, middle / np.linalg.norm(middle)])
        return float(2 * np.degrees(np.arccos(np.clip(cosine.min(axis=0).max(), -1.0, 1.0))))
    azimuth = np.sort(np.arctan2(points[:, 1], points[:, 0]))
    gaps = np.diff(azimuth, append=azimuth[0] + TURN)
    return float(np.degrees(TURN - gaps.max()))


# -- its pose, unit and file --------------------------------------------------------------------------------


def random_rotation(rng: Generator) -> Array:
    """A rotation (3, 3), uniform (QR of a normal matrix, with signs that make it so)."""
    q, r = np.linalg.qr(rng.standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def position(rng: Generator, extent: float, station: Array, metres: bool) -> Array:
    """Where the canonical origin goes, given where a station would be without translation."""
    place = pick(rng, PLACES)
    if place == "scanner":
        return -station
    if place == "far" and metres and extent > 0.1:
        return np.array([log_uniform(rng, FAR), log_uniform(rng, FAR), rng.uniform(-100.0, 1000.0)])
    return extent * rng.uniform(-3.0, 3.0, 3)


def file_step(rng: Generator, points: Array, extent: float, tolerable: float, unit: float) -> float | None:
    """The step of the file's numbers, as `rounded` takes it; finer where it would hide the shape."""
    coarsest = min(COARSEST_STEP * extent, tolerable)
    match pick(rng, FILES):
        case "float32" if np.spacing(np.float32(np.abs(points).max())) <= coarsest:
            return None
        case "1 mm" if 1e-3 * unit <= coarsest:
            return 1e-3 * unit
    return 0.0


def scanner_cloud(recipe: ScannerRecipe, index: int) -> SyntheticCloud:
    """Cloud `index` of a recipe, whatever was drawn before it."""
    rng = np.random.default_rng([recipe.seed, index, 1])
    kind = recipe.kinds[index % len(recipe.kinds)]
    count, strays = counts(rng, recipe)
    if recipe.decidable:
        count = max(count, POINTS_PER_UNKNOWN * PRIMITIVES[kind].dof)
    return deliver(rng, recipe.size, see(rng, recipe, kind, count), strays)


def counts(rng: Generator, recipe: ScannerRecipe | ForeignRecipe) -> tuple[int, int]:
    """How many points the surface gives, and how many gross outliers come to them."""
    total = round(log_uniform(rng, recipe.points))
    share = 0.0
    if rng.random() >= recipe.without_outliers:
        share = rng.uniform(recipe.outliers.low, recipe.outliers.high)
    return total - round(share * total), round(share * total)


def deliver(
    rng: Generator, size: Range, sight: Sight, strays: int, family: str = "scanner"
) -> SyntheticCloud:
    """The cloud in its pose and unit, with `strays` gross outliers, rounded as its file is."""
    unit = 1000.0 if rng.random() < MILLIMETRES else 1.0
    scale = unit * log_uniform(rng, size) / sight.extent
    rotation = random_rotation(rng)
    extent = scale * sight.extent
    stations = scale * sight.stations @ rotation.T
    translation = position(rng, extent, stations[0], metres=unit == 1.0)
    points = scale * sight.points @ rotation.T + translation

    few = strays <= MOST_DOMINANT_NEIGHBOUR * (strays + len(points))
    law: Literal["box", "neighbour"] = "neighbour" if few and rng.random() < 0.5 else "box"
    if strays:
        stray = gross_outliers(rng, points, strays, law)
        stray += scale * sight.noise * rng.standard_normal(stray.shape)
        points = np.concatenate([points, stray])
    outliers = np.concatenate([sight.mixed, np.ones(strays, dtype=bool)])
    station = np.concatenate([sight.station, np.full(strays, -1)])
    step = file_step(rng, points, extent, scale * sight.tolerable, unit)
    points, step_taken = rounded(points, step)
    order = rng.permutation(len(points))
    untouched = sight.noise == 0.0 and step_taken == 0.0
    return SyntheticCloud(
        points=points[order],
        primitive=sight.primitive and sight.primitive.transformed(rotation, translation, scale),
        kind=sight.kind,
        exact_share=float(np.mean(~outliers)) if untouched else 0.0,
        family=family,
        noise=scale * sight.noise,
        outlier_share=float(np.mean(outliers)),
        outliers=outliers[order],
        correlation=sight.correlation,
        arc=sight.arc,
        step=step_taken,
        stations=stations + translation,
        station=station[order],
        extent=extent,
    )
