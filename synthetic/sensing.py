"""Clouds of named sensors: a part, how the sensor sees it, what its errors do, where its file puts it.

A cloud is made in the canonical frame of its part, in metres. A sensor and a part are drawn until the kind
can be told under the sensor's own errors (`synthetic.deciding`); nothing is made easier to get there.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from primfit.fitting.primitives import PRIMITIVES
from primfit.fitting.primitives.torus import Torus

from .borders import comet_tail, edge_fringe, ragged
from .clouds import SHARES, SyntheticCloud
from .deciding import decidable
from .effects import Correlated, Effect, FormDeviation, Seen
from .noise import gross_outliers, rounded
from .parts import draw_part
from .patches import Patch
from .recipes import Range, SensorRecipe
from .scanner import (
    LINE_RATIO,
    MOST_RAYS,
    POINTS_PER_UNKNOWN,
    Mode,
    View,
    aim,
    arc_of,
    cast,
    log_uniform,
    pick,
    position,
    random_rotation,
    set_up,
    window_at,
)
from .sensors import FIELD_OF_VIEW, RING_PITCH, SENSORS, SPREAD, Sensor

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

OVERSAMPLED = 1.4
"""Hits aimed at over those wanted: the narrowed window and grazing rays cost some."""
DENSER = 4
"""Rays a vertex of a fused mesh."""
CELL_SIZES, CELLS_OFF = 15, 0.03
"""Sizes of cells that are tried for the wanted number of vertices, and by how much it may be missed."""
FEWEST_RINGS = 4
"""Of a spinning laser: three rings, each off by its own error, lie on a cylinder about anything.
"""
HIT_RINGS = (3, 8)
"""Of a contact machine: heights that it goes round at."""
HIT_JITTER = 0.1
"""Of the angle between two hits."""
OFF_AXIS = 0.35
"""The part lies up to so many radians from the optical axis."""
TRIES = 6
"""Parts and places that are drawn before another sensor is."""
MOST_SENSORS = 60

CROPPED, CROP_KEEPS = 0.5, Range(0.5, 0.95)
"""How many segments were cut by a region's growing, once, and what that leaves."""
FORMED = 0.6
"""How many parts deviate from their ideal form, by up to a noise scale in the root mean square."""
LOBES = (0, 0, 2, 3, 5)
"""Bows and barrels; ovals of chucks and bends; the odd lobes of centreless grinding (Rowe, Principles of
Modern Grinding Technology, 2014)."""
TOLERANCES = (
    (0.01, 0.0001),
    (0.03, 0.0002),
    (0.1, 0.0004),
    (0.3, 0.0008),
    (1.0, 0.004),
    (4.0, 0.010),
    (10.0, 0.012),
)
"""Sizes and what their form may deviate [m]: ISO 2768-2, class L, up to 0.3 m; floors and walls from 1 m as
in DIN 18202, table 3, row 3. Between them straight in the logarithms."""
BOW_RMS = 0.3
"""Root mean square of a parabola over its height, 2 / sqrt(45)."""
FRINGES, TAILS = 0.35, 0.25
"""How many clouds of optical sensors have them."""

FILES = (("float64", 0.2), ("float32", 0.45), ("decimals", 0.25), ("1 mm", 0.1))
DECIMALS = (4, 5, 6)
COARSEST_STEP = 0.7
"""Of a file's rounding, in noises: its own error is then a fifth of the noise."""


class UndecidableError(RuntimeError):
    """No sensor of the recipe sees a part of this kind so that it can be told."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A part as a sensor sees it, before errors; `noise` is the root mean square of the sensor's law."""

    sensor: str
    patch: Patch
    seen: Seen
    stations: Array
    noise: float
    effects: list[Effect]


# -- seeing -------------------------------------------------------------------------------------------------


def viewed(
    rng: Generator, sensor: Sensor, patch: Patch, mode: Mode, distance: float, wanted: int
) -> View | None:
    """About `wanted` hits of one station; None where it sees next to nothing."""
    aimed = aim(patch, mode, window_at(rng, set_up(rng, patch, mode, distance), patch.sample(rng, 256)))
    if aimed is None:
        return None
    window, cover = aimed
    rays = OVERSAMPLED * wanted / cover + 9
    wide, high = np.subtract(*window.azimuth[::-1]), np.subtract(*window.elevation[::-1])
    rows = max(3, round(np.sqrt(rays * high / (wide * log_uniform(rng, LINE_RATIO)))))
    if sensor.grid == "rings":
        rows = int(high / np.radians(log_uniform(rng, RING_PITCH)))
        if rows < FEWEST_RINGS:
            return None
    columns = max(3, round(rays / rows))
    return None if rows * columns > MOST_RAYS else cast(patch, mode, window, rows, columns)


def seen_in(rng: Generator, patch: Patch, view: View, station: int, flattest: float) -> Seen:
    """What a view holds where the cosine of the incidence is over `flattest`."""
    kept = view.cosine > flattest
    rays, points = view.directions[kept], view.points[kept]
    middle = rays.mean(axis=0)
    middle /= np.linalg.norm(middle)
    across = np.linalg.svd(middle[None])[2][1:]
    tilt = rng.uniform(-OFF_AXIS, OFF_AXIS, 2) / np.sqrt(2.0)
    optical = middle + tilt @ across
    row, column = np.divmod(view.ray[kept], view.columns)
    span = float(np.linalg.norm(np.ptp(rays, axis=0)))
    pitch = float(np.mean(view.distance)) * span / np.hypot(view.rows, view.columns)
    return Seen(
        points,
        patch.primitive.gradient(points),
        rays,
        view.distance[kept],
        view.cosine[kept],
        rays @ (optical / np.linalg.norm(optical)),
        (rays @ across.T) / (rays @ middle)[:, None],
        row + station * view.rows,
        pitch * column,
        np.full(len(rays), station),
        view.on_edge[kept],
        np.ones(len(rays)),
    )


def joined(parts: list[Seen]) -> Seen:
    return Seen(*(np.concatenate([getattr(p, name) for p in parts]) for name in Seen.__dataclass_fields__))


def from_stations(
    rng: Generator, sensor: Sensor, patch: Patch, mode: Mode, wanted: int
) -> tuple[Seen, Array] | None:
    """What one or a few stations see together, and where they stand."""
    extent = float(np.linalg.norm(np.ptp(patch.sample(rng, 200), axis=0)))
    distance = max(log_uniform(rng, sensor.reach), extent / FIELD_OF_VIEW)
    count = int(rng.integers(1, sensor.stations, endpoint=True))
    views = [viewed(rng, sensor, patch, mode, distance, -(-wanted // count)) for _ in range(count)]
    flattest = np.cos(np.radians(sensor.steepest))
    found = [view for view in views if view is not None and np.count_nonzero(view.cosine > flattest) > 3]
    if not found:
        return None
    seen = joined([seen_in(rng, patch, view, i, flattest) for i, view in enumerate(found)])
    return seen, np.array([view.origin for view in found])


def vertices(seen: Seen, wanted: int) -> Indices:
    """About `wanted` of the points, nearly regular: of each cell of a grid the one nearest to its middle.

    So marching cubes leaves them: one or a few a cell that the surface crosses.
    """
    low, high = 0.1 * seen.spacing, seen.extent
    for _ in range(CELL_SIZES):
        side = np.sqrt(low * high)
        found = len(np.unique(cells_of(seen.points, side)))
        if abs(found - wanted) <= CELLS_OFF * wanted:
            break
        low, high = (side, high) if found > wanted else (low, side)
    off = np.linalg.norm(np.mod((seen.points - seen.points.min(axis=0)) / side, 1.0) - 0.5, axis=1)
    order = np.argsort(off, kind="stable")
    return np.sort(order[np.unique(cells_of(seen.points, side)[order], return_index=True)[1]])


def cells_of(points: Array, side: float) -> Indices:
    """The number of the cell of a cubic grid that each point lies in."""
    place = np.floor((points - points.min(axis=0)) / side).astype(np.intp)
    columns, layers = place.max(axis=0)[1:] + 1
    return (place[:, 0] * columns + place[:, 1]) * layers + place[:, 2]


def hits(rng: Generator, patch: Patch, wanted: int) -> Seen:
    """Hits of a contact machine: a few rings at even heights (of a torus: around its tube), evenly around."""
    rings = int(rng.integers(*HIT_RINGS, endpoint=True))
    around, across = (patch.v, patch.u) if isinstance(patch.primitive, Torus) else (patch.u, patch.v)
    each = -(-wanted // rings)
    line = np.repeat(np.arange(rings), each)
    place = np.tile(np.arange(each), rings) + HIT_JITTER * rng.standard_normal(rings * each)
    turned = around[0] + (around[1] - around[0]) * np.clip((place + 0.5) / each, 0.0, 1.0)
    height = across[0] + (across[1] - across[0]) * (line + 0.5) / rings
    u, v = (height, turned) if isinstance(patch.primitive, Torus) else (turned, height)
    points = patch.primitive.surface(u, v)
    normals = patch.primitive.gradient(points)
    ones = np.ones(len(points))
    none = np.zeros(len(points), dtype=np.intp)
    flat = np.zeros((len(points), 2))
    return Seen(points, normals, -normals, ones, ones, ones, flat, line, turned, none, none > 0, ones)


# -- a scene ------------------------------------------------------------------------------------------------


def scene_of(rng: Generator, name: str, kind: str, count: int) -> Scene | None:
    """A part of this kind as the sensor sees it with `count` points; None where it does not."""
    sensor = SENSORS[name]
    patch, mode = draw_part(rng, kind, log_uniform(rng, sensor.size))
    keeps = rng.uniform(CROP_KEEPS.low, CROP_KEEPS.high) if rng.random() < CROPPED else 1.0
    wanted = int(count / keeps) + 2
    stations = np.zeros((0, 3))
    if sensor.grid == "hits":
        seen, keeps = hits(rng, patch, wanted), 1.0
    else:
        found = from_stations(rng, sensor, patch, mode, wanted * (DENSER if sensor.grid == "vertices" else 1))
        if found is None:
            return None
        seen, stations = found
    if sensor.grid == "vertices" and len(seen.points) > wanted:
        seen = seen.part(vertices(seen, int(1.05 * wanted) + 1))
    if len(seen.points) < wanted:
        return None
    if keeps < 1.0:
        seen = seen.part(ragged(rng, seen.points, keeps))
    seen = seen.part(np.sort(rng.permutation(len(seen.points))[:count]))
    if len(seen.points) < count:
        return None
    return with_errors(rng, name, patch, seen, stations)


def with_errors(rng: Generator, name: str, patch: Patch, seen: Seen, stations: Array) -> Scene:
    """The scene with the effects that its sensor has there, and those of the part's own form."""
    sigma = log_uniform(rng, SPREAD) * SENSORS[name].sigma(seen.distance, seen.cosine)
    noise = float(np.sqrt(np.mean(sigma**2)))
    seen = replace(seen, weight=sigma / noise)
    effects = SENSORS[name].errors(rng, seen, noise)
    if rng.random() < FORMED:
        size = min(noise * rng.random(), BOW_RMS * form_tolerance(seen.extent))
        waves = int(rng.choice(LOBES))
        effects.append(FormDeviation(size, patch, waves, rng.uniform(0.0, 2 * np.pi)))
    return Scene(name, patch, seen, stations, noise, effects)


def form_tolerance(size: float) -> float:
    """What a part of this size may deviate from its ideal form [m]."""
    sizes, tolerances = np.log(TOLERANCES).T
    return float(np.exp(np.interp(np.log(size), sizes, tolerances)))


def told_scene(rng: Generator, recipe: SensorRecipe, kind: str, count: int) -> Scene:
    """A scene of this kind that can be told."""
    for _ in range(MOST_SENSORS):
        name = recipe.sensors[int(rng.integers(len(recipe.sensors)))]
        for _ in range(TRIES):
            scene = scene_of(rng, name, kind, count)
            if scene is not None and decidable(rng, scene.patch, scene.seen, scene.effects):
                return scene
    raise UndecidableError(f"no {kind} of {count} points can be told by any of {', '.join(recipe.sensors)}")


# -- a cloud ------------------------------------------------------------------------------------------------


def erred(rng: Generator, scene: Scene) -> tuple[Array, Mask, dict[str, float]]:
    """The points with all errors, which are mixed pixels, and what each effect did (rms, or share)."""
    points = scene.seen.points
    sizes: dict[str, float] = {}
    for effect in sorted(scene.effects, key=lambda effect: effect.name == "depth steps"):
        moved = effect.applied(rng, scene.seen, points)
        size = float(np.sqrt(np.mean(np.sum((moved - points) ** 2, axis=1))))
        sizes[effect.name] = float(np.hypot(sizes.get(effect.name, 0.0), size))
        points = moved
    mixed = np.zeros(len(points), dtype=bool)
    if SENSORS[scene.sensor].background:
        if rng.random() < FRINGES:
            points, fringe = edge_fringe(rng, scene.seen, points, scene.noise)
            sizes["edge fringe"], mixed = float(fringe.mean()), mixed | fringe
        if rng.random() < TAILS:
            points, tail = comet_tail(rng, scene.seen, points)
            sizes["comet tail"], mixed = float(tail.mean()), mixed | tail
    return points, mixed, sizes


def file_step(rng: Generator, points: Array, noise: float, unit: float) -> float | None:
    """The step of the file's numbers, as `rounded` takes it; finer where it would outgrow the noise."""
    coarsest = COARSEST_STEP * noise
    match pick(rng, FILES):
        case "float32" if np.spacing(np.float32(np.abs(points).max())) <= coarsest:
            return None
        case "decimals" if 10.0 ** -DECIMALS[0] * unit <= coarsest:
            return float(unit * 10.0 ** -int(rng.choice(DECIMALS)))
        case "1 mm" if 1e-3 * unit <= coarsest:
            return 1e-3 * unit
    return 0.0


def sensor_cloud(recipe: SensorRecipe, index: int) -> SyntheticCloud:
    """Cloud `index` of a recipe, whatever was drawn before it."""
    rng = np.random.default_rng([recipe.seed, index, 4])
    kind = recipe.kinds[index % len(recipe.kinds)]
    total = round(log_uniform(rng, recipe.many if rng.random() < recipe.share_of_many else recipe.points))
    strays = 0
    if rng.random() >= recipe.without_outliers:
        strays = round(rng.uniform(recipe.outliers.low, recipe.outliers.high) * total)
    count = max(total - strays, POINTS_PER_UNKNOWN * PRIMITIVES[kind].dof)
    return delivered(rng, told_scene(rng, recipe, kind, count), strays)


def delivered(rng: Generator, scene: Scene, strays: int) -> SyntheticCloud:
    """The cloud with errors and gross outliers, in its pose and unit, rounded as its file is."""
    seen, primitive = scene.seen, scene.patch.primitive
    points, mixed, sizes = erred(rng, scene)
    off = primitive.signed_distance(points[~mixed])
    noise = float(np.sqrt(np.mean(off**2)))
    if strays:
        points = np.concatenate([points, gross_outliers(rng, points, strays, "box")])
        sizes["gross outliers"] = strays / len(points)

    unit = 1000.0 if rng.random() < share_in_millimetres(scene) else 1.0
    rotation = random_rotation(rng)
    stations = unit * scene.stations @ rotation.T
    station_at = stations[0] if len(stations) else unit * seen.extent * rng.standard_normal(3)
    translation = position(rng, unit * seen.extent, station_at, metres=unit == 1.0)
    points = unit * points @ rotation.T + translation
    points, step = rounded(points, file_step(rng, points, unit * noise, unit))

    outliers = np.concatenate([mixed, np.ones(strays, dtype=bool)])
    order = rng.permutation(len(points))
    return SyntheticCloud(
        points=points[order],
        primitive=primitive.transformed(rotation, translation, unit),
        kind=primitive.kind,
        family="sensor",
        noise=unit * noise,
        outlier_share=float(np.mean(outliers)),
        outliers=outliers[order],
        arc=arc_of(scene.patch, seen.points),
        step=step,
        stations=stations + translation if len(stations) else None,
        station=np.concatenate([seen.station, np.full(strays, -1)])[order],
        extent=unit * seen.extent,
        sensor=scene.sensor,
        effects=in_unit(sizes, unit),
        field_range=field_range(scene.effects, unit),
    )


def field_range(effects: list[Effect], unit: float) -> float | None:
    """How far the largest random field reaches, in the unit of the cloud."""
    correlated = [effect for effect in effects if isinstance(effect, Correlated)]
    if not correlated:
        return None
    return unit * max(correlated, key=lambda effect: effect.size).field.range


def share_in_millimetres(scene: Scene) -> float:
    """How often a file is in millimetres: small parts mostly, large ones seldom."""
    return 0.7 if scene.seen.extent < 0.5 else 0.1


def in_unit(sizes: Mapping[str, float], unit: float) -> dict[str, float]:
    return {name: size if name in SHARES else unit * size for name, size in sizes.items()}
