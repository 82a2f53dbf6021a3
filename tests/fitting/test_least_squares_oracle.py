"""Least squares to the accuracy of metrology: parts of 1 to 500 mm, anywhere within a metre of the origin.

The reference is the cheapest of many minima that scipy finds, taken to the last digit in long double. What is
fitted gets nothing but points, kind and criterion.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from fitting.config import Config
from fitting.primitives import KINDS, Cone, Cylinder, Plane, Primitive, Sphere, Torus, parameters
from fitting.recognize import recognize
from tests.fitting import oracles

ANGLE, LENGTH = 1e-7, 1e-4
"""What a reference value may be missed by, in radians and millimetres ..."""

RELATIVE = 1e-8
"""... and cost, angles, and lengths over the size of the cloud, where both are fitted to the same points."""

HALF_ANGLES = np.radians([0.6, 2.0, 5.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0])


@dataclass(frozen=True)
class Part:
    """A measured surface [mm] and the nominal one."""

    nominal: Primitive
    points: np.ndarray
    about: str


def part(kind: str, seed: int, exact: bool = False) -> Part:
    """A whole or partial feature of few or many points, under more or less noise or none."""
    rng = np.random.default_rng([KINDS.index(kind), seed])
    size, arc = 10.0 ** rng.uniform(0.0, 2.7), np.radians(rng.choice([30.0, 60.0, 90.0, 180.0, 360.0]))
    n, share = int(rng.choice([0, 1, 2, 5, 20, 200, 1000])), rng.uniform(0.2, 0.8)
    center = rng.uniform(-1.0, 1.0, 3) * (1000.0 - 0.75 * size)
    axis = rng.normal(size=3) if rng.random() < 0.7 else np.eye(3)[rng.integers(3)]
    radius, u = size / 2.0, lambda n: rng.uniform(0.0, arc, n)
    n += {"plane": 3, "sphere": 4, "cylinder": 5, "cone": 6, "torus": 7}[kind]
    sigma = 0.0 if exact else size * 10.0 ** rng.uniform(-6.5, -2.5)
    nominal: Primitive
    if kind == "plane":
        nominal = Plane(axis, center)
        points = nominal.surface(rng.uniform(-radius, radius, n), share * rng.uniform(-radius, radius, n))
    elif kind == "sphere":
        nominal = Sphere(center, radius)
        points = nominal.surface(
            rng.uniform(0.0, 2.0 * np.pi, n), np.arccos(rng.uniform(np.cos(arc / 2.0), 1.0, n))
        )
    elif kind == "cylinder":
        nominal = Cylinder(axis, center, radius)
        points = nominal.surface(u(n), 2.0 * share * rng.uniform(-radius, radius, n))
    elif kind == "cone":
        half_angle = rng.choice(HALF_ANGLES)
        top = radius / np.tan(half_angle)
        nominal = Cone(center - top * axis / np.linalg.norm(axis), axis, half_angle)
        points = nominal.surface(u(n), rng.uniform(max(top - 2.0 * size, share * top), top, n))
    else:
        nominal = Torus(center, axis, radius, share * 0.8 * radius)
        points = nominal.surface(u(n), rng.uniform(0.0, rng.choice([np.pi, 2.0 * np.pi]), n))
    about = f"{n} points of {size:.3g} mm over {np.degrees(arc):.0f} degrees, noise {sigma:.1e} mm, {nominal}"
    return Part(nominal, points + rng.normal(0.0, sigma, points.shape) if sigma else points, about)


def starts(kind: str, surface: Primitive, count: int, rng: np.random.Generator) -> Iterator[oracles.Surface]:
    """The surface, and others about it that are ever farther away."""
    for width in np.linspace(0.0, 0.3, count):
        step = rng.normal(0.0, 1.0, oracles.DOF[kind]) * width
        yield oracles.moved(kind, oracles.long(parameters(surface)), step)


def misses(
    kind: str, one: oracles.Surface, other: oracles.Surface, center: np.ndarray
) -> tuple[float, float]:
    """The largest difference in an angle and in a length; axes and cones are compared next to a centre.

    Of a cone that is the axis and the radius there: its apex may be metres away.
    """
    first, second = (_at(kind, surface, center) for surface in (one, other))
    angles = [np.linalg.norm(np.cross(first[0], second[0])), *np.abs(first[1] - second[1])]
    lengths = [np.linalg.norm(first[2] - second[2]), *np.abs(first[3] - second[3])]
    return float(max(angles)), float(max(lengths))


def _at(kind: str, surface: oracles.Surface, center: np.ndarray) -> tuple[oracles.Long, ...]:
    """Direction, angles, place and lengths of a surface as seen from a centre, in float64."""
    place, direction = surface[oracles.ANCHOR[kind]] - center, np.zeros(3, np.longdouble)
    if kind != "sphere":
        direction = surface[oracles.DIRECTION[kind]]
    height = place @ direction
    if kind == "plane":
        place = height * direction
    if kind in ("cylinder", "cone"):
        place = place - height * direction
    angles = [surface[name] for name in surface if name == "half_angle"]
    lengths = [surface[name] for name in surface if "radius" in name]
    if kind == "cone":
        lengths = [-height * np.tan(surface["half_angle"])]
    return tuple(np.array(each, np.float64) for each in (direction, angles, place, lengths))


def fitted(kind: str, made: Part) -> Primitive:
    answer = recognize(made.points, Config(kinds=(kind,), criterion="least_squares"))
    assert answer.status == "fitted" and answer.primitive is not None, f"{made.about}: {answer.message}"
    return answer.primitive


def check_against_oracle(kind: str, seed: int, count: int) -> None:
    made = part(kind, seed)
    center = made.points.mean(axis=0)
    size = float(np.sqrt(np.mean(np.sum((made.points - center) ** 2, axis=1))))
    points = (made.points - center) / size
    ours, nominal = (
        each.transformed(np.eye(3), -center / size, 1.0 / size).canonical(np.zeros(3))
        for each in (fitted(kind, made), made.nominal)
    )
    rng = np.random.default_rng(seed)
    ends = [*starts(kind, nominal, count, rng), oracles.long(parameters(ours))]
    theirs = oracles.least_squares_optimum(kind, iter(ends), points)
    found = oracles.long(parameters(ours))
    cost, best = (oracles.cost(kind, surface, points) for surface in (found, theirs))
    assert cost <= best * (1.0 + RELATIVE) + 1e-22 * len(points), made.about
    if len(points) == oracles.DOF[kind]:
        return  # several surfaces pass through them
    angle, length = misses(kind, found, theirs, np.zeros(3))
    slopes = oracles.derivatives(kind, theirs, points.astype(np.longdouble)).astype(np.float64)
    weakest = np.linalg.svd(slopes, compute_uv=False)[-1] / np.sqrt(len(points))
    # Neither can know more than the rounding of the coordinates lets them.
    rounding = 4.0 * float(np.spacing(np.abs(made.points).max())) / size / weakest
    reach = float(
        np.linalg.norm(found[oracles.ANCHOR[kind]].astype(np.float64))
    )  # of large spheres, far apexes
    assert angle <= RELATIVE + rounding, made.about
    assert length <= (RELATIVE + rounding) * max(1.0, reach), made.about
    if rounding < RELATIVE:
        assert angle <= ANGLE and length * size <= LENGTH, made.about


kinds = pytest.mark.parametrize("kind", KINDS)


@kinds
@pytest.mark.parametrize("seed", range(4))
def test_least_squares_is_the_optimum(kind: str, seed: int) -> None:
    check_against_oracle(kind, seed, count=2)


@pytest.mark.slow
@kinds
@pytest.mark.parametrize("seed", range(4, 60))
def test_least_squares_is_the_optimum_of_many_parts(kind: str, seed: int) -> None:
    check_against_oracle(kind, seed, count=6)


@kinds
@pytest.mark.parametrize("seed", range(25))
def test_nominal_parts_are_measured_as_they_are(kind: str, seed: int) -> None:
    """Points without noise: what is missed is the fit's own error."""
    made = part(kind, seed, exact=True)
    found = fitted(kind, made)
    if len(made.points) == made.nominal.dof:
        assert np.abs(found.signed_distance(made.points)).max() < 1e-9, made.about
        return
    center = made.points.mean(axis=0)
    ours, nominal = (oracles.long(parameters(each.canonical(center))) for each in (found, made.nominal))
    angle, length = misses(kind, ours, nominal, center)
    assert angle <= ANGLE and length <= LENGTH, made.about


@pytest.mark.parametrize("half_angle", HALF_ANGLES)
@pytest.mark.parametrize("arc", [60.0, 360.0])
def test_cones_of_every_half_angle(half_angle: float, arc: float) -> None:
    rng = np.random.default_rng(int(1000.0 * half_angle + arc))
    top = 40.0 / np.tan(half_angle)
    cone = Cone([500.0, -300.0, 800.0], rng.normal(size=3), half_angle)
    points = cone.surface(
        np.radians(rng.uniform(0.0, arc, 60)), rng.uniform(max(top - 120.0, 0.3 * top), top, 60)
    )
    found = fitted("cone", Part(cone, points, f"{np.degrees(half_angle):.1f} degrees"))
    angle, length = misses(
        "cone", oracles.long(parameters(found)), oracles.long(parameters(cone)), points.mean(axis=0)
    )
    assert angle <= ANGLE and length <= LENGTH
