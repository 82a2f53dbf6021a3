"""Minimum zone, minimum circumscribed and maximum inscribed surfaces, against optimisers that share nothing."""

from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import minimize

from fitting.config import Config
from fitting.errors import InvalidOptionError
from fitting.primitives import KINDS, Cylinder, Plane, Primitive, Sphere, parameters
from fitting.recognize import recognize
from tests.fitting import oracles
from tests.fitting.clouds import EXAMPLES, noisy, rotation, sample

Array = np.ndarray

examples = pytest.mark.parametrize("primitive", EXAMPLES.values(), ids=EXAMPLES.keys())
round_kinds = pytest.mark.parametrize("kind", ["sphere", "cylinder"])


def answer(points: Array, kind: str, criterion: str) -> Primitive:
    found = recognize(points, Config(kinds=(kind,), criterion=criterion))  # type: ignore[arg-type]
    assert found.status == "fitted" and found.primitive is not None, found.message
    return found.primitive


def largest(primitive: Primitive, points: Array) -> float:
    return float(np.abs(primitive.signed_distance(points)).max())


def all_around(kind: str, n: int, sigma: float, seed: int) -> Array:
    """Noisy points all around a sphere, or a cylinder as long as wide, in general position."""
    rng = np.random.default_rng(seed)
    if kind == "sphere":
        points = rng.normal(size=(n, 3))
        points /= np.linalg.norm(points, axis=1)[:, None]
    else:
        angle = rng.uniform(0.0, 2.0 * np.pi, n)
        points = np.stack([np.cos(angle), np.sin(angle), rng.uniform(-1.0, 1.0, n)], axis=1)
    points += rng.normal(0.0, sigma, (n, 3))
    return points @ rotation(seed).T + rng.normal(size=3)


def polished(kind: str, start: Primitive, points: Array, task: str) -> float:
    """The extreme value that SLSQP reaches on the problem with one more variable and all constraints."""
    surface, far = oracles.long(parameters(start)), points.astype(np.longdouble)
    free = oracles.DOF[kind] - (task != "zone")

    def values(step: Array) -> Array:
        moved = oracles.moved(kind, surface, np.append(step, np.zeros(oracles.DOF[kind] - free)))
        d = oracles.distances(kind, moved, far).astype(np.float64)
        if task == "zone":
            return np.concatenate([d, -d])
        rho = d + float(surface["radius"])
        return rho if task == "circumscribed" else -rho

    def slopes(step: Array) -> Array:
        units = 1e-6 * np.eye(free)
        return np.stack([(values(step + unit) - values(step - unit)) / 2e-6 for unit in units], axis=1)

    best = np.inf
    for seed in range(3):
        step = np.random.default_rng(seed).normal(0.0, 0.01 * seed, free)
        for _ in range(4):
            found = minimize(
                lambda x: x[-1],
                np.append(step, values(step).max()),
                jac=lambda x: np.append(np.zeros(free), 1.0),
                constraints={
                    "type": "ineq",
                    "fun": lambda x: x[-1] - values(x[:-1]),
                    "jac": lambda x: np.column_stack([-slopes(x[:-1]), np.ones(len(values(x[:-1])))]),
                },
                method="SLSQP",
                options={"ftol": 1e-16, "maxiter": 200},
            )
            step = found.x[:-1]
            best = min(best, float(values(step).max()))
    return best if task != "inscribed" else -best


def flatness(points: Array) -> float:
    """The least width between two parallel planes around the points, by trying all that touch enough of them.

    Either one plane holds three points of the hull, or each holds two.
    """
    edges = points[:, None] - points[None]
    pairs = np.array(list(combinations(range(len(points)), 2)))
    directions = edges[pairs[:, 0], pairs[:, 1]]
    normals = np.cross(directions[:, None], directions[None]).reshape(-1, 3)
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    return float(np.ptp(normals @ points.T, axis=1).min())


def smallest_sphere(points: Array) -> float:
    """Radius of the smallest sphere with all points inside, by trying all with two, three or four on them."""
    best = np.inf
    for size in (2, 3, 4):
        for chosen in combinations(points, size):
            origin, edges = chosen[0], np.array(chosen[1:]) - chosen[0]
            gram = edges @ edges.T
            center = origin + np.linalg.solve(2.0 * gram, np.diag(gram)) @ edges
            radius = float(np.linalg.norm(origin - center))
            if radius < best and np.linalg.norm(points - center, axis=1).max() <= radius * (1 + 1e-12):
                best = radius
    return best


@pytest.mark.parametrize("seed", range(4))
def test_flatness_is_the_least_width_of_all_pairs_of_planes(seed: int) -> None:
    points = noisy(EXAMPLES["plane"], 16, 0.02, seed)
    plane = answer(points, "plane", "minimum_zone")
    width = float(np.ptp(plane.signed_distance(points)))
    assert width == pytest.approx(flatness(points), rel=1e-10)
    assert largest(plane, points) == pytest.approx(width / 2.0, rel=1e-10)


@pytest.mark.parametrize("n", [4, 5, 9, 14])
@pytest.mark.parametrize("seed", range(4))
def test_the_circumscribed_sphere_is_the_smallest_of_all(n: int, seed: int) -> None:
    points = np.random.default_rng([n, seed]).normal(size=(n, 3))
    sphere = answer(points, "sphere", "minimum_circumscribed")
    assert isinstance(sphere, Sphere)
    assert sphere.radius == pytest.approx(smallest_sphere(points), rel=1e-11)


def test_the_circumscribed_sphere_of_two_points_far_apart() -> None:
    """Two points on it, and more freedom than contacts: it takes second derivatives to come to rest."""
    points = np.vstack(
        [[[2.0, 0.0, 0.0], [-2.0, 0.0, 0.0]], np.random.default_rng(0).normal(0, 0.3, (40, 3))]
    )
    sphere = answer(points, "sphere", "minimum_circumscribed")
    assert isinstance(sphere, Sphere)
    assert sphere.radius == pytest.approx(2.0, rel=1e-12)
    np.testing.assert_allclose(sphere.center, 0.0, atol=1e-8)


@pytest.mark.parametrize("n", [10, 40])
@examples
def test_the_minimum_zone_is_that_of_another_optimiser(primitive: Primitive, n: int) -> None:
    points = noisy(primitive, n, 0.02, seed=n)
    zone = answer(points, primitive.kind, "minimum_zone")
    assert largest(zone, points) <= polished(primitive.kind, zone, points, "zone") * (1.0 + 1e-9)
