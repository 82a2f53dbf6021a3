"""The sensors: how far and how densely they see, how large their errors are and of what sort, with sources.

A sensor's law gives the standard deviation of the noise along a ray. A share of its variance is correlated
(a rough field), the rest is white; to these come what the sensor does besides (steps, bows, rings, ...), each
drawn in proportion to that noise. Lengths are metres.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from .effects import (
    Correlated,
    DepthSteps,
    Effect,
    LineOffsets,
    LineWaves,
    RadialBow,
    Ripple,
    Seen,
    StationShift,
    White,
)
from .fields import Field, Rough, SelfAffine, Smooth
from .recipes import Range
from .scanner import log_uniform

Array = NDArray[np.float64]
Grid = Literal["rays", "rings", "vertices", "hits"]

SPREAD = Range(0.7, 1.4)
"""Devices, colours and surfaces differ: a law's noise is taken so many times, log-uniform."""
SHORTEST = 3.0
"""Correlation lengths start at so many spacings of the points, log-uniform up to the extent of the cloud."""
HURST = Range(0.3, 0.7)
"""Of self-affine fields, about Brownian (1/2)."""
LONGEST_WAVE = 2.0
"""Of self-affine fields, in extents; longer ones only move and tilt the whole."""
SELF_AFFINE = 0.3
"""Share of rough fields that are self-affine, where a sensor does not say; the others are exponential."""


def correlated(rng: Generator, seen: Seen, noise: float, share: Range, self_affine: float) -> list[Effect]:
    """White noise and a rough field, of which the latter has a drawn share of the variance."""
    part = rng.uniform(share.low, share.high)
    field: Field = Rough(between_spacing_and_extent(rng, seen))
    if rng.random() < self_affine:
        field = SelfAffine(rng.uniform(HURST.low, HURST.high), seen.spacing, LONGEST_WAVE * seen.extent)
    return [White(noise * np.sqrt(1.0 - part)), Correlated(noise * np.sqrt(part), field)]


def between_spacing_and_extent(rng: Generator, seen: Seen) -> float:
    return log_uniform(rng, Range(min(SHORTEST * seen.spacing, seen.extent), seen.extent))


def up_to(rng: Generator, noise: float, most: float = 1.0) -> float:
    """A size between nothing and `most` noise scales, uniform."""
    return noise * rng.uniform(0.0, most)


@dataclass(frozen=True)
class Sensor:
    """What a sensor does.

    Attributes
    ----------
    grid : a grid of rays; a few rings of rays; vertices of a fused mesh, nearly regular; rings of hits
    reach : distance from the part [m], log-uniform
    size : diagonal of the part [m], log-uniform, at most `FIELD_OF_VIEW` of the distance
    steepest : incidence [deg] beyond which nothing comes back
    stations : the largest number of stations
    sigma : noise along the ray, of distances (N,) and cosines of the incidence (N,)
    errors : the effects, given what is seen and the root mean square of `sigma` over it
    background : whether edges show what lies behind (fringes, comet tails)
    """

    grid: Grid
    reach: Range
    size: Range
    steepest: float
    stations: int
    sigma: Callable[[Array, Array], Array]
    errors: Callable[[Generator, Seen, float], list[Effect]]
    background: bool = True


FIELD_OF_VIEW = 1.0
"""Size over distance at most: 53 degrees, as depth cameras have."""


# -- depth cameras ------------------------------------------------------------------------------------------


def structured_light_sigma(distance: Array, cosine: Array) -> Array:
    """Kinect: 0.0012 + 0.0019 (z - 0.4)^2, and 0.0001 / sqrt(z) i^2 / (pi/2 - i)^2 for incidence i.

    Nguyen, Izadi and Lovell, "Modeling Kinect sensor noise for improved 3D reconstruction and tracking",
    3DIMPVT 2012, equations 2 and 3. Khoshelham and Elberink (Sensors 12, 2012) have 1.425e-3 z^2, about the
    same beyond 1 m.
    """
    incidence = np.arccos(cosine)
    grazing = 1e-4 / np.sqrt(distance) * (incidence / (np.pi / 2 - incidence)) ** 2
    return 0.0012 + 0.0019 * (distance - 0.4) ** 2 + grazing


KINECT_STEP = 2.85e-3
"""Depth resolution over z^2 [1/m] (Khoshelham and Elberink, Sensors 12, 2012, section 3)."""


def structured_light(rng: Generator, seen: Seen, noise: float) -> list[Effect]:
    """Noise of blocks of 9 x 9 pixels, depth steps, radial bow.

    Disparities come from windows (Konolige and Mihelich, "Technical description of Kinect calibration",
    2010), so that most of the noise is shared by neighbours. What calibration leaves grows from the middle of
    the image (Herrera, Kannala and Heikkila, PAMI 34, 2012; Teichman, Miller and Thrun, RSS 2013).
    """
    step = KINECT_STEP * float(np.sqrt(np.mean((seen.distance**2 * seen.depth) ** 2)))
    return [
        *correlated(rng, seen, noise, Range(0.5, 0.95), SELF_AFFINE),
        RadialBow(up_to(rng, noise)),
        DepthSteps(step / np.sqrt(12.0), KINECT_STEP),
    ]


def stereo_sigma(distance: Array, cosine: Array) -> Array:
    """z^2 / (f b) times 0.08 pixels, f b = 32 pixel metres (RealSense D435: 640 pixels, 50 mm).

    0.05 to 0.1 pixels are usual on textured walls (Keselman et al., "Intel RealSense stereoscopic depth
    cameras", CVPR workshops 2017, and the maker's guides to tuning).
    """
    return 0.08 / 32.0 * distance**2 / np.sqrt(cosine)


STEREO_STEP = 1.0 / 32.0 / 32.0
"""Disparities in 1/32 pixel over f b [1/m], as the D400 series hands them out."""


def stereo(rng: Generator, seen: Seen, noise: float) -> list[Effect]:
    """Noise shared within matching windows, wider where cost is aggregated (Hirschmueller, PAMI 30, 2008)."""
    step = STEREO_STEP * float(np.sqrt(np.mean((seen.distance**2 * seen.depth) ** 2)))
    return [
        *correlated(rng, seen, noise, Range(0.6, 0.97), SELF_AFFINE),
        RadialBow(up_to(rng, noise)),
        DepthSteps(step / np.sqrt(12.0), STEREO_STEP),
    ]


def time_of_flight_sigma(distance: Array, cosine: Array) -> Array:
    """1.5 mm up to 1 m, then with the square of the range, and with the root of the incidence's cosine.

    Fankhauser et al., "Kinect v2 for mobile robot navigation", ICAR 2015; Tolgyessy et al., Sensors 21, 2021
    (Azure Kinect: 1 to 2 mm up to 2 m).
    """
    return 0.0015 * np.maximum(distance, 1.0) ** 2 / np.sqrt(cosine)


def time_of_flight(rng: Generator, seen: Seen, noise: float) -> list[Effect]:
    """Multipath and wiggling bend what is seen by as much as the noise and more.

    Foix, Alenya and Torras, "Lock-in time-of-flight cameras: a survey", IEEE Sensors Journal 11, 2011.
    """
    return [*correlated(rng, seen, noise, Range(0.3, 0.9), SELF_AFFINE), RadialBow(up_to(rng, noise, 1.5))]


def phone_sigma(distance: Array, cosine: Array) -> Array:
    """4 mm and 2 per mille of the range.

    Luetzenburg, Kroon and Bjork, "Evaluation of the Apple iPhone 12 Pro LiDAR", Scientific Reports 11, 2021:
    about 1 cm, for objects over 10 cm.
    """
    return 0.004 + 0.002 * distance + 0.0 * cosine


def phone(rng: Generator, seen: Seen, noise: float) -> list[Effect]:
    """A few hundred spots are interpolated along the picture: hardly white, smooth and drifting."""
    smooth = Smooth(log_uniform(rng, Range(0.05, 0.3)) * seen.extent)
    return [
        *correlated(rng, seen, 0.8 * noise, Range(0.8, 0.98), 0.5),
        Correlated(0.6 * noise, smooth),
    ]


# -- laser scanners -----------------------------------------------------------------------------------------


def spinning_sigma(distance: Array, cosine: Array) -> Array:
    """15 mm at any range: "up to +-3 cm, typical" (Velodyne, VLP-16 datasheet 63-9229), as two sigma."""
    return np.full_like(distance, 0.015) / np.sqrt(cosine)


RING_PITCH = Range(0.4, 2.0)
"""Degrees between two rings: HDL-64E 0.4, VLP-16 2 (datasheets)."""


def spinning(rng: Generator, seen: Seen, noise: float) -> list[Effect]:
    """Each laser has its own range offset, as large as the noise or less.

    Glennie and Lichti, "Static calibration and analysis of the Velodyne HDL-64E S2", Remote Sensing 2, 2010:
    points miss planes by centimetres with the maker's calibration, by 1.3 cm after their own.
    """
    return [
        *correlated(rng, seen, noise, Range(0.2, 0.7), 0.0),
        LineOffsets(noise * rng.uniform(0.3, 1.0)),
    ]


def terrestrial_sigma(distance: Array, cosine: Array) -> Array:
    """0.6 mm and 0.1 per mille of the range, over the cosine of the incidence.

    Soudarissanane, Lindenbergh, Menenti and Teunissen, "Scanning geometry: influencing factor on the quality
    of terrestrial laser scanning points", ISPRS Journal 66, 2011; range noise as in Lichti, ISPRS Journal 61,
    2007, and in data sheets of phase-based scanners.
    """
    return (0.0006 + 1e-4 * distance) / cosine


def terrestrial(rng: Generator, seen: Seen, noise: float) -> list[Effect]:
    """Noise of the beam's footprint and of the surface, waves along profiles, stations off by 0 to 2 noises.

    Correlation: Jurek, Kuhlmann and Holst, Journal of Applied Geodesy 11, 2017; Kauker and Schwieger, ibid.
    Targets register stations to about the noise of a point (Reshetyuk, PhD thesis, KTH 2009).
    """
    effects = [
        *correlated(rng, seen, noise, Range(0.3, 0.9), SELF_AFFINE),
        LineWaves(up_to(rng, noise, 0.7), between_spacing_and_extent(rng, seen)),
    ]
    if seen.station.max() > 0:
        effects.append(StationShift(up_to(rng, noise, 2.0)))
    return effects


def laser_line_sigma(distance: Array, cosine: Array) -> Array:
    """1/5,000 of the distance: 40 um at 200 mm, mostly speckle, which no average removes.

    Dorsch, Haeusler and Herrmann, "Laser triangulation: fundamental uncertainty in distance measurement",
    Applied Optics 33, 1994.
    """
    return distance / 5000.0 / np.sqrt(cosine)


def laser_line(rng: Generator, seen: Seen, noise: float) -> list[Effect]:
    """Speckle along the line, and an offset of each line from the arm or the stage that carries the head.

    Arms hold 20 to 60 um (ISO 10360-8 statements of makers), as much as the line itself.
    """
    return [
        *correlated(rng, seen, noise, Range(0.2, 0.8), 0.0),
        LineOffsets(up_to(rng, noise)),
        LineWaves(up_to(rng, noise), between_spacing_and_extent(rng, seen)),
    ]


# -- other optics -------------------------------------------------------------------------------------------


def fringe_sigma(distance: Array, cosine: Array) -> Array:
    """1/15,000 of the distance, about a 10,000th of the field of view (VDI/VDE 2634 part 2 statements)."""
    return distance / 15_000.0 / cosine


def fringe(rng: Generator, seen: Seen, noise: float) -> list[Effect]:
    """Ripple at multiples of the projected period (gamma, shaking) and a bow that calibration leaves.

    Zhang, "Recent progresses on real-time 3D shape measurement using digital fringe projection techniques",
    Optics and Lasers in Engineering 48, 2010.
    """
    width = float(np.ptp(seen.image[:, 0]))
    return [
        *correlated(rng, seen, noise, Range(0.4, 0.9), SELF_AFFINE),
        Ripple(up_to(rng, noise), width / log_uniform(rng, Range(3.0, 40.0))),
        RadialBow(up_to(rng, noise)),
    ]


def photogrammetry_sigma(distance: Array, cosine: Array) -> Array:
    """1/1,500 of the distance: a pixel or so on the object at 20 to 24 megapixels.

    Remondino et al., "State of the art in high density image matching", Photogrammetric Record 29, 2014.
    """
    return distance / 1500.0 / np.sqrt(cosine)


def photogrammetry(rng: Generator, seen: Seen, noise: float) -> list[Effect]:
    """Rough surfaces without a scale of their own, and the dome of a self-calibrated lens.

    James and Robson, "Mitigating systematic error in topographic models derived from UAV and ground-based
    image networks", Earth Surface Processes and Landforms 39, 2014.
    """
    return [*correlated(rng, seen, noise, Range(0.7, 0.97), 0.7), RadialBow(up_to(rng, noise))]


def fused_mesh_sigma(distance: Array, cosine: Array) -> Array:
    """2.5 mm at 1 m: errors of some millimetres, up to 10.

    Meister, Izadi, Kohli et al., "When can we use KinectFusion for ground truth acquisition?", IROS workshop
    2012.
    """
    return 0.0025 * np.maximum(distance, 0.5) + 0.0 * cosine


VOXELS = Range(2.0, 8.0)
"""Reach of the truncated distance over which fusion averages, in spacings of the vertices (Newcombe et al.,
"KinectFusion", ISMAR 2011: truncation of some voxels)."""


def fused_mesh(rng: Generator, seen: Seen, noise: float) -> list[Effect]:
    """Averages over the truncation distance leave smooth noise; poses that drift leave a self-affine rest."""
    drift = SelfAffine(rng.uniform(HURST.low, HURST.high), seen.spacing, LONGEST_WAVE * seen.extent)
    part = rng.uniform(0.2, 0.8)
    return [
        White(0.1 * noise),
        Correlated(noise * np.sqrt(part), Smooth(log_uniform(rng, VOXELS) * seen.spacing)),
        Correlated(noise * np.sqrt(1.0 - part), drift),
    ]


def contact_sigma(distance: Array, cosine: Array) -> Array:
    """2 um: probing errors of ISO 10360-5 statements of bridge machines are 1.5 to 3 um."""
    return np.full_like(distance, 2e-6) + 0.0 * cosine


def contact(rng: Generator, seen: Seen, noise: float) -> list[Effect]:
    """Hits are nearly independent; the form of the part (`synthetic.sensing`) is as large as the noise."""
    return [White(noise)]


SENSORS: dict[str, Sensor] = {
    "structured light": Sensor(
        "rays", Range(0.6, 3.0), Range(0.1, 3.0), 75.0, 1, structured_light_sigma, structured_light
    ),
    "stereo": Sensor("rays", Range(0.4, 3.0), Range(0.1, 3.0), 75.0, 1, stereo_sigma, stereo),
    "time of flight": Sensor(
        "rays", Range(0.5, 3.5), Range(0.1, 3.0), 75.0, 1, time_of_flight_sigma, time_of_flight
    ),
    "phone": Sensor("rays", Range(0.4, 4.0), Range(0.2, 4.0), 75.0, 1, phone_sigma, phone),
    "spinning": Sensor("rings", Range(1.5, 15.0), Range(0.4, 8.0), 80.0, 1, spinning_sigma, spinning),
    "terrestrial": Sensor(
        "rays", Range(2.0, 30.0), Range(0.3, 10.0), 82.0, 2, terrestrial_sigma, terrestrial
    ),
    "laser line": Sensor("rays", Range(0.1, 0.3), Range(0.02, 0.3), 80.0, 2, laser_line_sigma, laser_line),
    "fringe": Sensor("rays", Range(0.3, 1.0), Range(0.02, 0.5), 75.0, 2, fringe_sigma, fringe),
    "photogrammetry": Sensor(
        "rays", Range(0.5, 20.0), Range(0.1, 10.0), 80.0, 3, photogrammetry_sigma, photogrammetry
    ),
    "fused mesh": Sensor(
        "vertices", Range(0.5, 1.5), Range(0.08, 1.5), 75.0, 4, fused_mesh_sigma, fused_mesh, background=False
    ),
    "contact": Sensor(
        "hits", Range(1.0, 1.0), Range(0.01, 0.4), 90.0, 1, contact_sigma, contact, background=False
    ),
}
"""By name; they are drawn with equal chances."""
